"""A run of a scene in virtual time."""
from . import _core
from .scene import checked


class Session(_core.Session):
    """A run in virtual time, with the bits of `tactus run --virtual-time`.

    scene: a path, a mapping or a Scene. hand: None, the scene's own script; a function hand(tick, tool_pose, force)
    that returns where the hand wants the tool at that tick, 3 numbers (position, m) or 7 (position and rotation w x y
    z), world frame, which the hand's impedance then follows; or 6 numbers, the wrench with which the hand pushes the
    tool wherever it is (force, N, and torque about the tool's origin, N m, world axes); or None: as before. It gets
    the tick's number, the tool's measured pose (7,) in the world and (6,) the force and torque on the hand, N and N
    m, world axes; what it raises ends the step and comes out of it. Or 'targets': step() takes an array of targets or
    wrenches. A scene with several hands takes a list of these, one for each; what each hand has is in `hands`.
    options: those of `tactus run`, such as coupling='static', ratio=5, rate_Hz=2000.

    One call at a time; while step() computes, other threads run.
    """

    def __init__(self, scene, hand=None, **options):
        super().__init__(checked(scene), hand, options)

    def replace(self, scene, hand=None, **options):
        """Another scene, from its start. Hand and options are those given here, else None and the defaults: none is kept
        of the former scene. A tape that was being written is closed. Views taken before show NaN from now on (roles 255):
        they are of the scene that is gone."""
        self._replace(checked(scene), hand, options)

    @property
    def bodies(self):
        """A dict for each body of the scene, by number: name, shape, sizes, mass_kg, inertia_kg_m2, friction."""
        return [self._scene.body(number) for number in range(self._scene.bodies)]

    def __enter__(self):
        return self

    def __exit__(self, *error):
        self.close()
