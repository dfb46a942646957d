// Results of operations as arrays and dicts of Python.
#pragma once

#include "apps/api/operation.h"
#include "apps/python/arrays.h"

namespace trephine::python {

/// Results of ticks as arrays. Shapes (N, 3) and (N,); with several hands (T, H, 3) and (T, H).
struct Touches {
  py::array_t<double> proxy, normal, force, torque;
  py::array_t<bool> contact;
  py::array_t<std::int32_t> item;
  py::array_t<std::uint32_t> faults;

  explicit Touches(std::vector<py::ssize_t> shape) {
    const std::vector<py::ssize_t> flat(shape.begin(), shape.end() - 1);
    shape.back() = 3;
    for (auto* vectors : {&proxy, &normal, &force, &torque}) *vectors = py::array_t<double>(shape);
    contact = py::array_t<bool>(flat);
    item = py::array_t<std::int32_t>(flat);
    faults = py::array_t<std::uint32_t>(flat);
  }
};

/// Writes results into the memory of the arrays. Does not need the lock of the interpreter.
struct TouchWriter {
  double *proxy, *normal, *force, *torque;
  bool* contact;
  std::int32_t* item;
  std::uint32_t* faults;

  explicit TouchWriter(Touches& touches)
      : proxy(touches.proxy.mutable_data()),
        normal(touches.normal.mutable_data()),
        force(touches.force.mutable_data()),
        torque(touches.torque.mutable_data()),
        contact(touches.contact.mutable_data()),
        item(touches.item.mutable_data()),
        faults(touches.faults.mutable_data()) {}
  void write(std::size_t i, const Touch& touch) const {
    const auto put = [i](double* out, const glm::dvec3& v) {
      out[3 * i] = v.x, out[3 * i + 1] = v.y, out[3 * i + 2] = v.z;
    };
    put(proxy, touch.proxy_world);
    put(normal, touch.normal_world);
    put(force, touch.force_world);
    put(torque, touch.torque_world);
    contact[i] = touch.has_contact;
    item[i] = touch.item;
    faults[i] = touch.faults;
  }
};

/// An event as Python objects.
struct PyEvent {
  std::uint64_t tick;
  int hand;
  py::tuple position;
  std::string name;
  py::dict fields;
};

/// Triangles as arrays.
struct PySurface {
  py::array_t<double> vertices;
  py::array_t<std::uint32_t> triangles;

  explicit PySurface(const Surface& surface)
      : vertices({static_cast<py::ssize_t>(surface.vertices_world.size()), py::ssize_t{3}},
                 surface.vertices_world.empty() ? nullptr : &surface.vertices_world[0].x),
        triangles({static_cast<py::ssize_t>(surface.triangles.size() / 3), py::ssize_t{3}},
                  surface.triangles.data()) {}
};

/// Returns a score with its findings, a dict each.
py::dict dict_of(const Score& judged);

void bind_results(py::module_& module);

}  // namespace trephine::python
