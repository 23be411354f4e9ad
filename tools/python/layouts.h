// The library's plain values as NumPy has them: structured types of the same layout, and read-only views of arrays of
// them. Thread: with the GIL held.
#pragma once

#include <pybind11/numpy.h>

#include <span>

#include "tactus/state.h"
#include "tactus/tick.h"

namespace tactus::python {

pybind11::dtype tick_type();
pybind11::dtype contact_type();
pybind11::dtype border_contact_type();

// An array of `shape` in memory that `owner` keeps: nothing is copied, nothing can be written through it.
pybind11::array view_of(const pybind11::dtype& type, std::vector<pybind11::ssize_t> shape,
                        std::vector<pybind11::ssize_t> strides, const void* data, const pybind11::handle& owner);

// One field of an array of structures, such as the positions of all bodies: (n, `width`) doubles.
template <class Item, class Field>
pybind11::array field_of(std::span<const Item> items, Field Item::*field, const pybind11::handle& owner) {
  constexpr auto kWidth = static_cast<pybind11::ssize_t>(sizeof(Field) / sizeof(double));
  const void* data = items.empty() ? nullptr : &(items.front().*field);
  return view_of(pybind11::dtype::of<double>(), {static_cast<pybind11::ssize_t>(items.size()), kWidth},
                 {static_cast<pybind11::ssize_t>(sizeof(Item)), static_cast<pybind11::ssize_t>(sizeof(double))}, data,
                 owner);
}

template <class Item>
pybind11::array items_of(const pybind11::dtype& type, std::span<const Item> items, const pybind11::handle& owner) {
  return view_of(type, {static_cast<pybind11::ssize_t>(items.size())}, {static_cast<pybind11::ssize_t>(sizeof(Item))},
                 items.data(), owner);
}

}  // namespace tactus::python
