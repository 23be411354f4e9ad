#!/usr/bin/env python3
"""Largest root of the loop between both worlds, for the vertical motion of a stack of cubes that the border cuts.

All contacts press, so that the loop is linear: one cycle is a matrix, and its eigenvalues are the roots. Both worlds
solve soft contacts as rt/physics/contact does (warm start, a biased sweep upwards, a relax sweep downwards); the lowest
member is the buffer; the ghost follows sim/exchange/apparent_inertia.h. A root of size 1 or more: the stack shakes.

  stack_roots.py [--cubes 20] [--members 5 10 12] [--ratios 2 3 4 5 6 8 10 16] [--contact-hertz 1000] [--sub-steps 4]
Prints a line a ratio and member count: the largest root with the mean velocity taken over one step and over two.
"""
import argparse
from dataclasses import dataclass

import numpy as np

TICK_S = 1e-3
MASS_KG = 0.1  # no root depends on it
DAMPING_RATIO = 10.0


class Soft:
    """A contact as in softness.h, in sub-steps of h [s]."""

    def __init__(self, hertz, h):
        turn = 2 * np.pi * hertz
        self.h, self.turn = h, turn
        a1 = 2 * DAMPING_RATIO + h * turn
        a2 = h * turn * a1
        self.bias_rate, self.mass_scale, self.impulse_scale = turn / a1, a2 / (1 + a2), 1 / (1 + a2)

    def added_inertia(self, step_s):
        return self.turn * step_s * (2 * DAMPING_RATIO + self.turn * step_s)


class Ghost:
    def __init__(self, admittance, position, velocity, drive):
        self.admittance, self.position, self.velocity, self.drive = admittance, position, velocity, drive


@dataclass
class Column:
    """Row k: position and velocity of cube k, and the impulse of the contact below it."""

    z: np.ndarray
    v: np.ndarray
    impulses: np.ndarray


def step(column, sub_steps, soft, ghost=None):
    """Moves a column that stands on the ground, or on a ghost.

    Returns the impulse of the lowest contact, summed over the sub-steps."""
    z, v, impulses, h = column.z, column.v, column.impulses, soft.h
    count, lowest = len(z), np.zeros_like(z[0])

    def apply(k, impulse):
        v[k] += impulse / MASS_KG
        if k > 0:
            v[k - 1] -= impulse / MASS_KG
        elif ghost is not None:
            ghost.velocity = ghost.velocity - ghost.admittance * impulse

    def solve(k, biased):
        if k > 0:
            gap, speed, inverse_mass, own_share = z[k] - z[k - 1], v[k] - v[k - 1], 2 / MASS_KG, 1
        elif ghost is not None:
            gap, speed, inverse_mass = z[0] - ghost.position, v[0] - ghost.velocity, 1 / MASS_KG + ghost.admittance
            own_share = 2 / MASS_KG / inverse_mass
        else:
            gap, speed, inverse_mass, own_share = z[0], v[0], 1 / MASS_KG, 1
        if biased:
            keep = 1 / (1 + own_share * soft.impulse_scale / soft.mass_scale)
            change = -keep * (speed + soft.bias_rate * gap) / inverse_mass - (1 - keep) * impulses[k]
        else:
            change = -speed / inverse_mass
        impulses[k] += change
        apply(k, change)

    for _ in range(sub_steps):
        if ghost is not None:
            ghost.velocity = ghost.velocity + h * ghost.drive
        for k in range(count):
            apply(k, impulses[k])
        for k in range(count):
            solve(k, True)
        z += h * v
        if ghost is not None:
            ghost.position = ghost.position + h * ghost.velocity
        for k in reversed(range(count)):
            solve(k, False)
        lowest = lowest + impulses[0]
    return lowest


def outside_response(count, soft, step_s):
    """Admittance W of the highest cube of a column on the ground, and its row of W M."""
    k = np.eye(count) * MASS_KG
    for i in range(count):
        link = soft.added_inertia(step_s) * MASS_KG * (1 if i == 0 else 0.5)
        k[i, i] += link
        if i > 0:
            k[i - 1, i - 1] += link
            k[i, i - 1] -= link
            k[i - 1, i] -= link
    inverse = np.linalg.inv(k)
    return inverse[-1, -1], inverse[-1] * MASS_KG


def largest_root(cubes, members, ratio, hertz, sub_steps, steps_of_mean):
    step_s, outside = ratio * TICK_S, cubes - members
    soft = Soft(hertz, TICK_S / sub_steps)
    admittance, kept = outside_response(outside, soft, step_s)
    sizes = [cubes] * 3 + [members] * 3 + [1] * 3 + [outside]

    def cycle(state):
        parts = [part.copy() for part in np.split(state, np.cumsum(sizes)[:-1])]
        z, v, impulses, sub_z, sub_v, sub_impulses, position, velocity, drive, mean_before = parts
        z[outside + 1:], v[outside + 1:] = sub_z[1:], sub_v[1:]  # all but the buffer are imposed
        start = z[:outside].copy()
        whole, sub_world = Column(z, v, impulses), Column(sub_z, sub_v, sub_impulses)
        below = impulses[outside:outside + 1].copy() * 0
        # The load on the outside: of the contact under the lowest member.
        for _ in range(ratio * sub_steps):
            step(whole, 1, soft)
            below += impulses[outside]
        step(sub_world, ratio * sub_steps, soft, Ghost(admittance, position[0], velocity[0], drive[0]))
        sub_z[0], sub_v[0] = z[outside], v[outside]
        mean = (z[:outside] - start) / step_s
        used = mean if steps_of_mean == 1 else 0.5 * (mean + mean_before)
        velocity = used[-1:] + (kept @ (v[:outside] - used))[None]
        drive = admittance * below / step_s
        return np.concatenate([z, v, impulses, sub_z, sub_v, sub_impulses, z[outside - 1:outside], velocity, drive, mean])

    roots = np.linalg.eigvals(cycle(np.eye(sum(sizes))))
    return roots[np.argmax(abs(roots))]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cubes", type=int, default=20)
    parser.add_argument("--members", type=int, nargs="+", default=[5, 10, 12])
    parser.add_argument("--ratios", type=int, nargs="+", default=[2, 3, 4, 5, 6, 8, 10, 16])
    parser.add_argument("--contact-hertz", type=float, default=1000)
    parser.add_argument("--sub-steps", type=int, default=4, help="per tick, in both worlds")
    options = parser.parse_args()
    if not all(1 < members < options.cubes for members in options.members):
        parser.error(f"--members: 2 to {options.cubes - 1}, fewer than there are cubes")
    print("ratio members   one step           two steps")
    for ratio in options.ratios:
        for members in options.members:
            one, two = (largest_root(options.cubes, members, ratio, options.contact_hertz, options.sub_steps, n)
                        for n in (1, 2))
            print(f"{ratio:5} {members:7}   {abs(one):.2f} ({one:+.2f})   {abs(two):.2f} ({two:+.2f})")


if __name__ == "__main__":
    main()
