// Operations in Python: poses in, forces out as arrays; commands with keywords; events, measures, surfaces
// and images.
#include "apps/python/bind_operation.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "apps/python/bind_scan.h"
#include "apps/python/open_operation.h"
#include "apps/python/results.h"

namespace trephine::python {

using glm::dvec3;
using glm::ivec3;

namespace {

template <class Pixel>
py::array_t<Pixel> image_of(const Image<Pixel>& image) {
  return py::array_t<Pixel>({image.rows, image.columns}, image.pixels.data());
}

Touches run(PyOperation& self, const py::object& positions, const py::object& orientations,
            const py::object& buttons) {
  std::vector<py::ssize_t> shape, turn_shape;
  const auto places = doubles_of(positions, "positions", 3, shape);
  const std::size_t hands = shape.size() == 3 ? static_cast<std::size_t>(shape[1]) : 1;
  const std::size_t count = static_cast<std::size_t>(places.size()) / 3;
  py::array_t<double, py::array::c_style> turns;
  if (!orientations.is_none()) {
    turns = doubles_of(orientations, "orientations", 4, turn_shape);
    if (turn_shape.size() != shape.size() || !std::equal(shape.begin(), shape.end() - 1, turn_shape.begin()))
      raise({.what = "the shapes of orientations and positions differ",
             .where = "orientations",
             .found = std::to_string(turns.size() / 4) + " quaternions",
             .expected = std::to_string(count) + " in the shape of positions, with four numbers each"});
    const double* q = turns.data();
    for (std::size_t i = 0; i < count; ++i, q += 4) {
      const double square = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
      if (std::abs(square - 1) > 1e-3)
        raise({.what = "a quaternion is not a unit quaternion",
               .where = "orientations, pose " + std::to_string(i),
               .found = "length " + std::to_string(std::sqrt(square)),
               .expected = "w, x, y, z of a rotation",
               .remedy = "divide each row by its length"});
    }
  }
  const auto pressed = buttons_of(buttons, shape);
  Touches touches(shape);
  const TouchWriter writer(touches);
  const double* place = places.data();
  const double* turn = orientations.is_none() ? nullptr : turns.data();
  const std::uint32_t* press = pressed.data();
  const bool is_one = pressed.size() == 1;
  self.with([&](Operation& operation) {
    if (hands != operation.hand_count())
      raise({.what = "the number of hands differs from that of the operation",
             .where = "positions",
             .found = std::to_string(hands),
             .expected = std::to_string(operation.hand_count()),
             .remedy = "pass an array of shape (ticks, hands, 3)"});
    std::vector<Pose> poses(hands);
    constexpr std::size_t k_signals = 4096;  // ticks between two tests for signals, such as Ctrl+C
    for (std::size_t i = 0; i < count; i += hands) {
      if (i / hands % k_signals == k_signals - 1) {
        py::gil_scoped_acquire locked;
        if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      }
      for (std::size_t h = 0; h < hands; ++h) {
        const std::size_t k = i + h;
        poses[h].position_world = {place[3 * k], place[3 * k + 1], place[3 * k + 2]};
        if (turn) poses[h].orientation = {turn[4 * k], turn[4 * k + 1], turn[4 * k + 2], turn[4 * k + 3]};
        poses[h].buttons = press[is_one ? 0 : k];
      }
      const auto result = operation.step(poses);
      if (!result) raise(result.error());
      for (std::size_t h = 0; h < hands; ++h) writer.write(i + h, result.value()[h]);
    }
    return 0;
  });
  return touches;
}

PyEvent event_of(const Event& event) {
  return {event.tick, event.hand, tuple_of(event.position_world), std::string(event.value.name()),
          fields_of(event.value)};
}

py::list events_from(PyOperation& self, std::size_t first) {
  std::vector<Event> all = self.with([first](Operation& operation) {
    std::vector<Event> copies;
    for (std::size_t i = first; i < operation.event_count(); ++i) copies.push_back(operation.event(i));
    return copies;
  });
  py::list list;
  for (const Event& event : all) list.append(event_of(event));
  return list;
}

py::list events(PyOperation& self) { return events_from(self, 0); }

py::dict measures(PyOperation& self) {
  py::dict result;
  for (const Measure& measure : self.with([](Operation& operation) { return operation.measures(); }))
    result[py::str(measure.name)] = measure.value;
  return result;
}

py::dict score(PyOperation& self, const py::object& judgements) {
  std::vector<MeasuredValue> all;
  for (const auto& one : argument<py::sequence>(judgements, "judgements", "a list of trephine.MeasuredValue"))
    all.push_back(argument<MeasuredValue>(one, "judgements", "a list of trephine.MeasuredValue"));
  return dict_of(self.with([&](Operation& operation) { return value_of(operation.score(all)); }));
}

py::array slice(PyOperation& self, const py::object& middle, const py::object& right, const py::object& up,
                double pixel, int columns, int rows) {
  ImagePlane plane;
  plane.middle_world = vector_of(middle, "middle");
  plane.right = vector_of(right, "right");
  plane.up = vector_of(up, "up");
  plane.pixel = pixel, plane.columns = columns, plane.rows = rows;
  return image_of(self.with([&](Operation& operation) { return value_of(operation.slice(plane)); }));
}

py::array_t<std::uint8_t> render(PyOperation& self, const py::object& side, const py::object& function,
                                 int columns, int rows) {
  const RenderView view{text_of(side, "side", "the name of a side"),
                        text_of(function, "function", "the name of a transfer function"), columns, rows};
  const Image<Colour> image =
      self.with([&](Operation& operation) { return value_of(operation.render(view)); });
  return py::array_t<std::uint8_t>({image.rows, image.columns, 3}, image.pixels[0].data());
}

py::array xray(PyOperation& self, const py::object& isocentre, double primary, double secondary, double pixel,
               int columns, int rows) {
  const XrayPose pose{vector_of(isocentre, "isocentre"), primary, secondary, pixel, columns, rows};
  return image_of(self.with([&](Operation& operation) { return value_of(operation.xray(pose)); }));
}

py::dict query(PyOperation& self, const py::object& points) {
  std::vector<py::ssize_t> shape;
  const auto numbers = doubles_of(points, "points", 3, shape);
  if (shape.size() != 2)
    raise({.what = "an argument has the wrong shape",
           .where = "points",
           .found = std::to_string(shape.size()) + " dimensions",
           .expected = "(N, 3)"});
  const auto count = static_cast<std::size_t>(shape[0]);
  std::vector<glm::dvec3> positions(count);
  for (std::size_t i = 0; i < count; ++i)
    positions[i] = {numbers.data()[3 * i], numbers.data()[3 * i + 1], numbers.data()[3 * i + 2]};
  const std::vector<Sample> samples =
      self.with([&](Operation& operation) { return operation.query(positions); });
  py::array_t<int> items(shape[0]), labels(shape[0]);
  py::array_t<bool> solid(shape[0]), removed(shape[0]);
  py::array_t<double> values(shape[0]), distances(shape[0]), gradients({shape[0], py::ssize_t{3}});
  for (std::size_t i = 0; i < count; ++i) {
    const Sample& sample = samples[i];
    items.mutable_data()[i] = sample.item, labels.mutable_data()[i] = sample.label;
    solid.mutable_data()[i] = sample.is_solid, removed.mutable_data()[i] = sample.is_removed;
    values.mutable_data()[i] = sample.value, distances.mutable_data()[i] = sample.cut_distance;
    for (int a = 0; a < 3; ++a)
      gradients.mutable_data()[3 * i + static_cast<std::size_t>(a)] = sample.gradient_world[a];
  }
  py::dict result;
  result["solid"] = solid, result["removed"] = removed, result["value"] = values;
  result["gradient"] = gradients, result["cut_distance"] = distances, result["item"] = items;
  result["label"] = labels;
  return result;
}

py::list explain_force(PyOperation& self, std::uint64_t tick, int hand) {
  const std::size_t hands = self.with([](Operation& operation) { return operation.hand_count(); });
  if (hand < 0 || static_cast<std::size_t>(hand) >= hands)
    raise({.what = "unknown hand",
           .where = "hand",
           .found = std::to_string(hand),
           .expected = "0 to " + std::to_string(hands - 1)});
  py::list parts;
  for (const ForcePart& part :
       self.with([&](Operation& operation) { return value_of(operation.explain_force(tick, hand)); })) {
    py::dict row;
    row["name"] = part.name, row["force"] = tuple_of(part.force_world),
    row["torque"] = tuple_of(part.torque_world);
    parts.append(row);
  }
  return parts;
}

py::array read(PyOperation& self, const py::object& low, const py::object& high) {
  const VoxelRange range{indices_of(low, "low"), indices_of(high, "high")};
  const std::vector<std::int16_t> voxels =
      self.with([&](Operation& operation) { return value_of(operation.read(range)); });
  const ivec3 size = range.high - range.low + 1;
  return py::array_t<std::int16_t>({size.z, size.y, size.x}, voxels.data());
}

py::list bodies(PyOperation& self) {
  py::list list;
  for (const Body& body : self.with([](Operation& operation) { return operation.bodies(); })) {
    py::dict row;
    row["id"] = body.id, row["holder"] = body.holder, row["mm3"] = body.mm3;
    row["position"] = tuple_of(body.position_world), row["rotation"] = tuple_of(body.rotation);
    row["surface"] = body.surface ? py::cast(PySurface(*body.surface)) : py::none();
    list.append(row);
  }
  return list;
}

}  // namespace

void bind_operation(py::module_& module) {
  bind_results(module);
  py::class_<Hand>(module, "Hand", "A hand with an instrument. `trephine modules` lists the instruments.")
      .def(py::init([](const std::string& instrument, double radius, const std::string& method,
                       const std::vector<std::string>& effects, const py::kwargs& parameters) {
             return Hand{instrument, words_of(parameters), radius, method, effects};
           }),
           py::arg("instrument") = "", py::kw_only(), py::arg("radius") = 0.0, py::arg("method") = "",
           py::arg("effects") = py::list(),
           "`radius`: radius of the ball that touches the matter, mm; 0: the radius of the instrument, or a "
           "point if it has no radius. `method`: "
           "contact method. `effects`: further forces, such as \"viscous damping=0.004\". Other keywords are "
           "parameters of the instrument: Hand(\"burr\", diameter=4).")
      .def("__repr__", [](const Hand& hand) {
        return "<trephine.Hand " +
               (hand.instrument.empty() ? std::string("without instrument") : hand.instrument) +
               (hand.parameters.empty() ? "" : " " + hand.parameters) + ">";
      });

  py::class_<Snapshot>(module, "Snapshot", "The state of an operation at one moment, with its undo history.")
      .def_property_readonly("tick", &Snapshot::tick, "Number of executed ticks.");
  py::class_<PyOperation, SharedOperation>(
      module, "Operation",
      "Surgery on a scan: poses in, forces out. One thread at a time uses an operation; several operations share "
      "no changing data. Equal input gives equal bits.")
      .def(py::init([](const py::args&, const py::kwargs&) -> SharedOperation {
        throw py::type_error(
            "an operation has no constructor; use Operation.open(\"head\") or Operation.reopen(session)");
      }))
      .def_static(
          "open", &open, py::arg("source"),
          "Opens a path (DICOM folder, file or case), \"head\", \"spine\" or a Scan. Keywords: `hand` or "
          "`hands`; the touched solid: `iso`, `window` or `label`; `plan`: True uses the plan of a built-in phantom; "
          "`rate`: ticks per second (1000); `smallest_burr`: mm; `record`: path of a new session. "
          "Assumptions about the scan give warnings.")
      .def_static(
          "reopen", &reopen, py::arg("session"), py::arg("scan") = py::none(),
          "Opens a recorded operation at its beginning, read-only. `scan`: the path or the Scan that was "
          "operated on, if it is neither a phantom nor in the session's file. A warning reports that the "
          "end of the session was lost.")
      .def(
          "run", &run, py::arg("positions"), py::arg("orientations") = py::none(), py::arg("buttons") = 0,
          "Executes a tick per pose. `positions`: (N, 3), or (T, H, 3) for H hands, world, mm. `orientations`: "
          "unit quaternions w, x, y, z of shape (N, 4) or (T, H, 4). `buttons`: one number, or one per pose; 1 "
          "activates the tool. Releases the interpreter's lock.")
      .def(
          "command",
          [](PyOperation& self, const py::args& names, py::kwargs keywords) {
            // The name of the command is positional, because a parameter of a command may have any name.
            if (names.size() != 1 || !py::isinstance<py::str>(names[0]))
              raise({.what = "no command selected",
                     .where = "command",
                     .found = std::to_string(names.size()) + " positional arguments",
                     .expected = "the name of a command, then its parameters by keyword",
                     .remedy = "call command(\"burr\", diameter=3)"});
            int hand = 0;
            if (keywords.contains("hand")) {
              hand = argument<int>(keywords["hand"], "command hand", "0 for the first hand");
              PyDict_DelItemString(keywords.ptr(), "hand");
            }
            const auto name = names[0].cast<std::string>();
            const std::string words = words_of(keywords);
            self.with([&](Operation& operation) {
              check(operation.command(name, words, hand));
              return 0;
            });
          },
          "Executes a command, and finishes the job that it starts: command(\"burr\", diameter=3). `trephine "
          "modules` lists the commands.")
      .def(
          "undo", [](PyOperation& self) { self.with([](Operation& o) { return check(o.undo()), 0; }); },
          "Undoes the last stroke or command.")
      .def("redo", [](PyOperation& self) { self.with([](Operation& o) { return check(o.redo()), 0; }); })
      .def(
          "reset", [](PyOperation& self) { self.with([](Operation& o) { return check(o.reset()), 0; }); },
          "Clears faults, contact and force in the next tick.")
      .def(
          "snapshot",
          [](PyOperation& self) { return self.with([](Operation& o) { return value_of(o.snapshot()); }); },
          "Returns the current state, for restore().")
      .def(
          "restore",
          [](PyOperation& self, const Snapshot& snapshot) {
            self.with([&](Operation& o) { return check(o.restore(snapshot)), 0; });
          },
          py::arg("snapshot"),
          "Returns to a snapshot of this operation; equal input then gives equal bits. Raises Error while the "
          "operation is recorded.")
      .def(
          "end", [](PyOperation& self) { self.with([](Operation& o) { return check(o.end()), 0; }); },
          "Ends the operation and its recording.")
      .def(
          "go_to",
          [](PyOperation& self, std::uint64_t tick) {
            self.with([tick](Operation& o) {
              if (o.is_recorded() && tick > o.tick_count())
                raise({.what = "the tick is beyond the end of the session",
                       .where = "tick",
                       .found = std::to_string(tick),
                       .expected = "at most " + std::to_string(o.tick_count())});
              return check(o.go_to(tick)), 0;
            });
          },
          py::arg("tick"), "Goes to the state of a reopened operation after this number of ticks.")
      .def(
          "verify", [](PyOperation& self) { self.with([](Operation& o) { return check(o.verify()), 0; }); },
          "Replays all of a reopened operation. Raises Error with the first difference.")
      .def_property_readonly("measures", &measures, "Values by name: \"removed\", \"nearest to dura\", ...")
      .def("score", &score, py::arg("judgements") = py::tuple(),
           "Judges the current state. Returns a dict: `points`, the `possible` points, the weight that is "
           "`not_judged`, `critical` (the names of bad findings of weight 4 or more), and `findings`, a dict "
           "each. Does not judge the hands' motion, which only `trephine score` does. `judgements`: further "
           "values, which are judged in the same way.")
      .def_property_readonly("events", &events, "All events so far.")
      .def_property_readonly(
          "event_count",
          [](PyOperation& self) { return self.with([](Operation& o) { return o.event_count(); }); },
          "Number of events so far.")
      .def(
          "events_since", [](PyOperation& self, std::size_t first) { return events_from(self, first); },
          py::arg("first"), "Events from this index on: events_since(n) after event_count was n.")
      .def_property_readonly("bodies", &bodies, "Detached parts and implants, a dict each.")
      .def_property_readonly(
          "removed_mm3",
          [](PyOperation& self) { return self.with([](Operation& o) { return o.removed_mm3(); }); })
      .def_property_readonly(
          "tick", [](PyOperation& self) { return self.with([](Operation& o) { return o.tick(); }); },
          "Number of executed ticks.")
      .def_property_readonly(
          "hand_count",
          [](PyOperation& self) { return self.with([](Operation& o) { return o.hand_count(); }); },
          "Number of hands.")
      .def_property_readonly(
          "rate", [](PyOperation& self) { return self.with([](Operation& o) { return o.rate_hz(); }); },
          "Ticks per second.")
      .def_property_readonly(
          "tick_count",
          [](PyOperation& self) { return self.with([](Operation& o) { return o.tick_count(); }); },
          "Number of recorded ticks.")
      .def_property_readonly(
          "is_whole",
          [](PyOperation& self) {
            return self.with([](Operation& o) { return !o.is_recorded() || o.is_whole(); });
          },
          "False if the end of a reopened session was lost.")
      .def_property_readonly(
          "hash", [](PyOperation& self) { return self.with([](Operation& o) { return o.hash(); }); },
          "Equal states have equal hashes.")
      .def_property_readonly(
          "spacing",
          [](PyOperation& self) {
            return tuple_of(self.with([](Operation& o) { return o.scan().frame.spacing(); }));
          },
          "Distances between voxel centres along x, y, z, mm.")
      .def_property_readonly(
          "array",
          [](py::object self) {
            const volume::Volume* scan = nullptr;
            self.cast<PyOperation&>().with([&](Operation& o) { return scan = &o.scan(), 0; });
            return voxels_of(*scan, self);
          },
          "Intensities of the uncut scan, a read-only view of shape (z, y, x) that keeps the operation alive.")
      .def_property_readonly(
          "scan",
          [](PyOperation& self) {
            return Scan{.volume = self.with([](Operation& o) { return o.shared_scan(); })};
          },
          "The uncut scan: voxels, labels and frame. Shares the voxels.")
      .def_property_readonly(
          "item_names",
          [](PyOperation& self) { return self.with([](Operation& o) { return o.item_names(); }); },
          "Names of the touched structures; `item` of Touches is the index.")
      .def_property_readonly(
          "trajectories",
          [](PyOperation& self) {
            py::dict lines;
            for (const PlannedLine& one : self.with([](Operation& o) { return o.trajectories(); }))
              lines[py::str(one.name)] =
                  py::make_tuple(tuple_of(one.entry_world), tuple_of(one.target_world));
            return lines;
          },
          "Trajectories of the plan by name: entry and target, world, mm.")
      .def_property_readonly(
          "landmarks",
          [](PyOperation& self) {
            py::dict positions;
            for (const PlannedPosition& one : self.with([](Operation& o) { return o.landmarks(); }))
              positions[py::str(one.name)] = tuple_of(one.position_world);
            return positions;
          },
          "Landmarks of the plan by name: position, world, mm.")
      .def(
          "take_changed",
          [](PyOperation& self) -> py::object {
            const auto range = self.with([](Operation& o) { return o.take_changed(); });
            if (!range) return py::none();
            const auto corner = [](const ivec3& v) { return py::make_tuple(v.x, v.y, v.z); };
            return py::make_tuple(corner(range->low), corner(range->high));
          },
          "Voxels that may have changed since the last call: (low, high) as in read(); None if nothing changed.")
      .def("read", &read, py::arg("low"), py::arg("high"),
           "Current intensities of the voxels low .. high (x, y, z), both included, of shape (z, y, x).")
      .def(
          "surface",
          [](PyOperation& self, std::size_t item) {
            return PySurface(self.with([item](Operation& o) { return value_of(o.surface(item)); }));
          },
          py::arg("item") = 0, "Surface of a structure with its cuts. `item`: index of the structure.")
      .def(
          "query", &query, py::arg("points"),
          "Matter at points (N, 3), world, mm: arrays solid, removed, value (of the structure's field, uncut), "
          "gradient (per mm), cut_distance (mm to removed matter, negative inside it), item (index of the "
          "structure; -1 outside the scan) and label.")
      .def(
          "explain_force", &explain_force, py::arg("tick"), py::arg("hand") = 0,
          "Returns the parts whose sum is the force of a recorded tick: name, force (N), torque (N mm). Only "
          "for a reopened session, which this call moves to the end of the tick.")
      .def("slice", &slice, py::arg("middle"), py::arg("right") = py::make_tuple(1, 0, 0),
           py::arg("up") = py::make_tuple(0, 0, 1), py::arg("pixel") = 0.5, py::arg("columns") = 512,
           py::arg("rows") = 512, "Intensities in a plane, int16 (rows, columns); -32768 outside the scan.")
      .def("render", &render, py::arg("side") = "oblique", py::arg("function") = "bone",
           py::arg("columns") = 512, py::arg("rows") = 512,
           "Returns a volume rendering with the cuts, bodies and models: uint8 of shape (rows, columns, 3).")
      .def("xray", &xray, py::arg("isocentre"), py::arg("primary") = 0.0, py::arg("secondary") = 0.0,
           py::arg("pixel") = 0.3, py::arg("columns") = 1024, py::arg("rows") = 1024,
           "X-ray of a CT, uint8 (rows, columns). Angles of the C-arm in degrees, as in DICOM.")
      .def("__reduce__", [](const PyOperation&) -> py::object {
        throw py::type_error("operations cannot be pickled; record a session and reopen it");
      });
}

}  // namespace trephine::python
