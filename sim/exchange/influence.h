// A body's influence on the proxy, between 0 and 1: the order in which the contact graph is cut.
//
// Two contacts c, c' of one body a are coupled by tau = |J_c M_a^-1 J_c'^T| / sqrt(A_cc A_c'c'), A_cc: the inverse
// effective mass of contact c between its two bodies. tau is 1 where an impulse at one contact moves the other fully, 0
// where they are decoupled. A heavy body has a small tau, so the search ends there. The influence of a body is the
// largest product of tau over all paths from the proxy; a contact with the proxy has 1. tau is at least kMinTau,
// since friction couples contacts whose normals do not. Found by label setting over contacts (Dijkstra), largest first.
// Thread: the global world's. Units: SI. Frame: world. Work: linear in the contacts visited, times contacts per body;
// it stops when no remaining body can be among the best. Allocates nothing once its heap has grown.
#pragma once

#include <span>
#include <vector>

#include "sim/exchange/contact_graph.h"

namespace tactus::sim {

struct Influenced {
  BodyIndex index{};
  double influence{0};
};

class Influence {
 public:
  static constexpr double kMinTau = 0.01;
  static constexpr double kNearDiscount = 0.5;  // influence of a body near the proxy without a contact

  Influence(std::uint32_t max_bodies, std::uint32_t max_touches);

  // Bodies by decreasing influence, ties in a fixed order, without the proxy. `near`: bodies close to the
  // proxy. Finds all bodies with at least half of the influence of the `enough`-th best, or all if there are fewer than
  // `enough`. Valid until the next call.
  std::span<const Influenced> find(const ContactGraph& graph, BodySpan<const physics::Body> bodies, BodyIndex proxy,
                                   std::span<const BodyIndex> near, std::uint32_t enough) noexcept;

 private:
  struct Side {  // one body's side of a contact
    double inverse_mass{0};
    Vec3d normal, lever_arm, inertia_lever;  // n, r x n, I^-1 (r x n)
  };
  struct Label {  // a path that enters `index` through `touch`; value: its product of tau
    double value{0};
    BodyIndex index{};
    std::uint32_t touch{0};
  };
  struct ByValue {
    bool operator()(const Label& a, const Label& b) const noexcept;
  };

  static constexpr std::uint32_t kNear = 0xffffffffu;  // Label::touch of a body in `near`: no contact

  static Side side_of(const ContactEdge& touch, const physics::Body& body) noexcept;
  static double inverse_effective_mass(const Side& a, const Side& b) noexcept;
  void prepare(std::uint32_t touch, std::span<const ContactEdge> touches,
               BodySpan<const physics::Body> bodies) noexcept;
  void push(double value, BodyIndex index, std::uint32_t touch, std::uint32_t side) noexcept;
  void expand(const Label& label, const ContactGraph& graph, BodySpan<const physics::Body> bodies,
              BodyIndex proxy) noexcept;

  // Per contact: both sides; inverse effective mass [1/kg]; best value per direction. Valid if prepared_ == search_.
  std::vector<std::array<Side, 2>> sides_;
  std::vector<double> inverse_mass_;
  std::vector<std::array<double, 2>> best_;
  std::vector<std::uint64_t> prepared_;
  BodyVector<std::uint64_t> found_;  // number of the last search that found it
  std::vector<Label> heap_;
  std::vector<Influenced> result_;
  std::uint64_t search_{0};
};

}  // namespace tactus::sim
