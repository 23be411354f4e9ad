// The report of an import: what was taken over, what was changed and by how much, what was left out, what is refused.
// Plain values. Thread: any normal one.
#pragma once

#include <string>
#include <vector>

namespace tactus::scene_import {

// Something that a scene cannot have.
struct Refusal {
  std::string kind;      // the word for --drop; empty: it cannot be dropped
  std::string file;      // without its folder
  unsigned line{0};      // 0: not known
  std::string what;      // the element and what is wrong with it
  std::string accepted;  // what to do
};

struct Account {
  unsigned bodies{0}, joints{0};        // of the scene, without the proxy
  std::vector<std::string> taken_over;  // "7 boxes"
  std::vector<std::string> changed;
  std::vector<std::string> left_out;
  std::vector<std::string> dropped;  // by --drop: also in left_out
  std::vector<Refusal> refused;

  void change(std::string text) { changed.push_back(std::move(text)); }
  void refuse(Refusal refusal) { refused.push_back(std::move(refusal)); }
};

// Kinds that --drop accepts.
const std::vector<std::string>& droppable_kinds();

// Moves refusals of these kinds to `left_out` and `dropped`.
void drop(const std::vector<std::string>& kinds, Account& account);

// "gripper.xml:12: what; accepted: ...", a line each.
std::string lines_of(const std::vector<Refusal>& refused);

// For people.
std::string text_of(const Account& account);

}  // namespace tactus::scene_import
