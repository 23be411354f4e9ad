// tactus.Tape's own part: a tape's ticks in memory, read once; columns are views of them, as `tactus export` has them.
#include <fmt/format.h>
#include <pybind11/stl.h>

#include <algorithm>

#include "rt/base/status.h"
#include "tactus/tape.h"
#include "tools/python/classes.h"
#include "tools/python/columns.h"
#include "tools/python/errors.h"
#include "tools/session/tape_player.h"

namespace py = pybind11;

namespace tactus::python {
namespace {

using exporting::Row;

struct Gap {
  std::uint64_t after_tick{0};  // the last tick before it
  std::uint64_t ticks{0};       // number of missing ticks
};

class TapeObject : public ZeroedByPython {
 public:
  static std::shared_ptr<TapeObject> open(const py::object& file) {
    const std::filesystem::path path = path_of(file, "Tape");
    auto tape = std::make_shared<TapeObject>();
    Status status = Status::good();
    {
      py::gil_scoped_release others;
      status = tape->read(path);
    }
    if (!status.ok()) raise(Error::Kind::kFile, status.message());
    return tape;
  }

  // `self`: this tape's Python object, which the view keeps.
  static py::array column(const py::object& self, const py::object& name) {
    const auto& tape = self.cast<const TapeObject&>();
    tape.made("Tape");
    return column_of(tape.rows_, column_of_name(name), tape.period_s_, self);
  }

  static const exporting::Column& column_of_name(const py::object& name) {
    if (!py::isinstance<py::str>(name))
      raise(Error::Kind::kOption, fmt::format("Tape: {} is no column; accepted: a name of Tape.columns", shown(name)));
    return column_named(text_of(name));
  }

  // A lone surrogate, which no column has, becomes "?".
  static std::string text_of(const py::object& text) {
    return text.attr("encode")("utf-8", "replace").cast<std::string>();
  }

  // Ticks that adopted a snapshot.
  py::array_t<std::uint64_t> cycles() const {
    std::vector<std::uint64_t> ticks;
    for (const Row& row : rows_)
      if (row.tick.adopts != 0) ticks.push_back(row.tick.out.tick);
    return py::array_t<std::uint64_t>(static_cast<py::ssize_t>(ticks.size()), ticks.data());
  }

  // One entry per fault, at the tick in which it latches.
  py::list faults() const {
    py::list faults;
    Fault before = Fault::kNone;
    for (const Row& row : rows_) {
      const Fault fault = row.tick.out.fault;
      if (fault != before && fault != Fault::kNone)
        faults.append(py::make_tuple(row.tick.out.tick, static_cast<std::uint32_t>(fault), describe(fault)));
      before = fault;
    }
    return faults;
  }

  py::list gaps() const {
    py::list gaps;
    for (const Gap& gap : gaps_) gaps.append(py::make_tuple(gap.after_tick, gap.ticks));
    return gaps;
  }

  Replay replay() const {
    made("Tape");
    Replay replay;
    Error error;
    {
      py::gil_scoped_release others;
      error = replay_tape(path_, replay);
    }
    raise_if(error);
    return replay;
  }

  std::size_t ticks() const noexcept { return rows_.size(); }
  double period_s() const noexcept { return period_s_; }
  const std::string& damage() const noexcept { return damage_; }
  const std::string& warning() const noexcept { return warning_; }
  const std::string& made_by() const noexcept { return made_by_; }
  const std::string& scene_text() const noexcept { return scene_text_; }
  const std::string& scene_name() const noexcept { return scene_name_; }

 private:
  Status read(const std::filesystem::path& path) {
    path_ = path;
    auto opened = session::open_tape(path.string());
    if (!opened.ok()) return opened.status();
    session::OpenTape& tape = opened.value();
    period_s_ = tape.settings.options.period_s();
    made_by_ = tape.settings.made_by;
    scene_name_ = tape.settings.scene_name;
    scene_text_ = tape.settings.scene_source;
    warning_ = tape.warning;
    return session::walk(tape, {.record = [this](const loop::TapeRecord& record) { return take(record); },
                                .damage =
                                    [this](const std::string& what, std::uint64_t) {
                                      if (damage_.empty()) damage_ = what;
                                    },
                                .progress = {}});
  }

  Status take(const loop::TapeRecord& record) {
    if (record.kind == loop::kTickRecord) {
      const auto tick = session::tick_of(record);
      if (!tick.ok()) return tick.status();
      note_gap(tick.value().out.tick);
      rows_.push_back({tick.value(), {}});
    } else if (record.kind == loop::kTimesRecord) {
      const auto times = session::times_of(record);
      if (!times.ok()) return times.status();
      if (!rows_.empty() && times.value().tick == rows_.back().tick.out.tick) rows_.back().times = times.value();
    }
    return Status::good();
  }

  void note_gap(std::uint64_t tick) {
    if (rows_.empty()) return;
    const std::uint64_t last = rows_.back().tick.out.tick;
    if (tick > last + 1) gaps_.push_back({last, tick - last - 1});
  }

  std::filesystem::path path_;
  std::vector<Row> rows_;
  std::vector<Gap> gaps_;
  double period_s_{0};
  std::string damage_, warning_, made_by_, scene_name_, scene_text_;
};

}  // namespace

void add_tape(py::module_& module) {
  py::class_<Replay>(module, "Replay", "What came of Tape.replay().")
      .def_readonly("ticks", &Replay::ticks, "On the tape.")
      .def_readonly("compared", &Replay::compared, "Ticks computed again and compared.")
      .def_readonly("different", &Replay::different, "Compared ticks with another result.")
      .def_readonly("lost_ticks", &Replay::lost_ticks, "Lost to damage, where the numbers show it.")
      .def_readonly("same_bits", &Replay::same_bits,
                    "At least one tick was compared, and all are the same, bit by bit.")
      .def_readonly("first_difference", &Replay::first_difference, "In words; empty: none.")
      .def_readonly("damage", &Replay::damage, "The first one, as `tactus replay` says it; empty: none.")
      .def_readonly("warning", &Replay::warning, "Such as a tape of another instruction set; empty: none.");
  py::class_<TapeObject, std::shared_ptr<TapeObject>>(module, "Tape",
                                                      "A tape, read into memory. tape[\"force_x_N\"] is the column "
                                                      "that `tactus export` writes, (ticks,), read-only and "
                                                      "without a copy.")
      .def(py::init(&TapeObject::open), py::arg("path"))
      .def("__getitem__", &TapeObject::column, py::arg("column"))
      .def("__contains__",
           [](const TapeObject&, const py::object& name) {
             return py::isinstance<py::str>(name) && std::ranges::count(column_names(), TapeObject::text_of(name)) > 0;
           })
      .def("__len__", &TapeObject::ticks)
      .def("__iter__", [](const TapeObject&) { return py::iter(py::cast(column_names())); })
      .def(
          "keys", [](const TapeObject&) { return column_names(); },
          "The columns' names, as of a mapping: pandas.DataFrame({k: tape[k] for k in tape}).")
      .def_property_readonly(
          "columns", [](const TapeObject&) { return column_names(); }, "The columns' names; the unit is in them.")
      .def(
          "about", [](const TapeObject&, const py::object& name) { return about(TapeObject::column_of_name(name)); },
          py::arg("column"), "Of a column: unit, frame, group, meaning.")
      .def_property_readonly("cycles", &TapeObject::cycles,
                             "(cycles,) uint64: the ticks that adopted a snapshot, each the first of its cycle.")
      .def_property_readonly("faults", &TapeObject::faults, "List of (tick, code, words), where a fault latched.")
      .def_property_readonly("gaps", &TapeObject::gaps, "List of (last tick before it, ticks missing).")
      .def_property_readonly("period_s", &TapeObject::period_s, "Of a tick, s.")
      .def_property_readonly("damage", &TapeObject::damage, "The first damage, in one line; empty: none.")
      .def_property_readonly("warning", &TapeObject::warning, "A tape of another instruction set; empty: none.")
      .def_property_readonly("made_by", &TapeObject::made_by, "The version that wrote it.")
      .def_property_readonly("scene_name", &TapeObject::scene_name, "Of the scene that was run.")
      .def_property_readonly("scene_text", &TapeObject::scene_text, "The scene that was run, with its files' data.")
      .def("replay", &TapeObject::replay, "Computes every tick again and compares, as `tactus replay`.");
}

}  // namespace tactus::python
