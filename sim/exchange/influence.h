// How much a body can change what the proxy feels, between 0 and 1: the order in which the contact graph is cut.
//
// Two contacts c, c' of one body a are coupled by tau = |J_c M_a^-1 J_c'^T| / sqrt(A_cc A_c'c'), where A_cc is the
// inverse effective mass of contact c between its two bodies: 1 where one contact moves with the other, 0 where it
// does not notice. A heavy body has a small tau: the search stops there by itself. The influence of a body is the
// largest product of tau over all ways from the proxy; a contact with the proxy has 1. tau counts at least kLeastTau:
// friction couples contacts whose normals do not. Found by label setting over contacts (Dijkstra), largest first.
// Thread: the global world's. Units: SI. Frame: world. Work: linear in the contacts visited, times contacts per body;
// it stops when nothing left can be among the best. Allocates nothing once its heap has grown.
#pragma once

#include <span>
#include <vector>

#include "sim/exchange/contact_graph.h"

namespace tactus::sim {

struct Influenced {
  std::uint32_t slot{0};
  double influence{0};
};

class Influence {
 public:
  static constexpr double kLeastTau = 0.01;
  static constexpr double kNearDiscount = 0.5;  // of a body that does not touch the proxy yet, but may soon

  Influence(std::uint32_t max_bodies, std::uint32_t max_touches);

  // Bodies by falling influence, ties in a fixed order, the proxy left out. `near` are bodies (slots) close to the
  // proxy. Finds all whose influence is at least half of the `enough`-th best one's, and all where there are fewer.
  // Valid until the next call.
  std::span<const Influenced> find(const ContactGraph& graph, std::span<const physics::Body> bodies,
                                   std::uint32_t proxy, std::span<const std::uint32_t> near,
                                   std::uint32_t enough) noexcept;

 private:
  struct Side {  // a contact as one of its bodies sees it
    double inverse_mass{0};
    Vec3d normal, lever_arm, inertia_lever;  // n, r x n, I^-1 (r x n)
  };
  struct Label {  // a way that enters `slot` through `touch`
    double value{0};
    std::uint32_t slot{0}, touch{0};
  };
  struct ByValue {
    bool operator()(const Label& a, const Label& b) const noexcept;
  };

  static constexpr std::uint32_t kNear = 0xffffffffu;  // entered through no contact: close to the proxy

  static Side side_of(const ContactEdge& touch, const physics::Body& body) noexcept;
  static double inverse_effective_mass(const Side& a, const Side& b) noexcept;
  void prepare(std::uint32_t touch, std::span<const ContactEdge> touches,
               std::span<const physics::Body> bodies) noexcept;
  void push(double value, std::uint32_t slot, std::uint32_t touch, std::uint32_t side) noexcept;
  void expand(const Label& label, const ContactGraph& graph, std::span<const physics::Body> bodies,
              std::uint32_t proxy) noexcept;

  // Per contact: both sides, inverse effective mass; best value per direction. Valid where prepared_ is this search's.
  std::vector<std::array<Side, 2>> sides_;
  std::vector<double> inverse_mass_;
  std::vector<std::array<double, 2>> best_;
  std::vector<std::uint64_t> prepared_;
  std::vector<std::uint64_t> found_;  // by slot: this search's number where already found
  std::vector<Label> heap_;
  std::vector<Influenced> result_;
  std::uint64_t search_{0};
};

}  // namespace tactus::sim
