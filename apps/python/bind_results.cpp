#include "apps/python/results.h"
#include "haptics/force/faults.h"

namespace trephine::python {

py::dict dict_of(const Score& judged) {
  py::list findings;
  for (const Finding& f : judged.findings) {
    py::dict row;
    row["name"] = f.name, row["value"] = f.value, row["unit"] = f.unit, row["verdict"] = f.verdict;
    row["reason"] = f.reason, row["points"] = f.points, row["weight"] = f.weight, row["tick"] = f.tick;
    row["position"] =
        f.position ? py::object(py::make_tuple(f.position->x, f.position->y, f.position->z)) : py::none();
    findings.append(row);
  }
  py::dict result;
  result["points"] = judged.points, result["possible"] = judged.possible;
  result["not_judged"] = judged.not_judged, result["critical"] = judged.critical;
  result["findings"] = findings;
  return result;
}

void bind_results(py::module_& module) {
  py::class_<MeasuredValue>(
      module, "MeasuredValue",
      "A value that a program measured, with the limits for its points: all at `full_at`, none at "
      "`zero_at`, linear between. Without limits it is only reported.")
      .def(py::init([](std::string name, std::optional<double> value, std::string unit, std::string reason,
                       std::optional<double> full_at, std::optional<double> zero_at, double weight) {
             if (full_at.has_value() != zero_at.has_value())
               raise({.what = "a judgement has only one limit",
                      .where = name,
                      .expected = "full_at and zero_at, or neither"});
             if (full_at && *full_at == *zero_at)
               raise({.what = "the limits of a judgement are equal",
                      .where = name,
                      .found = std::to_string(*full_at),
                      .expected = "different values of full_at and zero_at",
                      .remedy = "for a limit without a range, pass 1 or 0 as the value, with full_at=1 and "
                                "zero_at=0"});
             if (!value && reason.empty()) reason = "It was not measured.";
             return MeasuredValue{
                 std::move(name),     value, std::move(unit), std::move(reason), full_at.value_or(0),
                 zero_at.value_or(0), weight};
           }),
           py::arg("name"), py::arg("value"), py::kw_only(), py::arg("unit") = "", py::arg("reason") = "",
           py::arg("full_at") = py::none(), py::arg("zero_at") = py::none(), py::arg("weight") = 1.0);
  py::class_<Touches>(
      module, "Touches",
      "Results of ticks: arrays of shape (N, 3) and (N,), or (T, H, 3) and (T, H) for H hands.")
      .def_readonly("proxy", &Touches::proxy, "Position of the proxy, world, mm.")
      .def_readonly("normal", &Touches::normal, "Unit normal toward the proxy; 0 without contact.")
      .def_readonly("force", &Touches::force, "Force for the device, N.")
      .def_readonly("torque", &Touches::torque, "Torque for the device, N mm.")
      .def_readonly("contact", &Touches::contact, "True in contact.")
      .def_readonly("item", &Touches::item, "Index of the touched structure; -1 without contact.")
      .def_readonly(
          "faults", &Touches::faults,
          "Bits of Fault: faults that are latched until reset(), and limits that were applied to the "
          "force. A latched fault brings the force to 0.");

  py::object flag = py::module_::import("enum").attr("IntFlag");
  py::dict faults;
  faults["NOT_FINITE"] = static_cast<int>(haptics::fault_not_finite);
  faults["FORCE_LIMIT"] = static_cast<int>(haptics::fault_magnitude);
  faults["SLEW_LIMIT"] = static_cast<int>(haptics::fault_slew);
  faults["STALE_SCENE"] = static_cast<int>(haptics::fault_stale_scene);
  faults["LOST_DEVICE"] = static_cast<int>(haptics::fault_lost_device);
  faults["FULL_RING"] = static_cast<int>(haptics::fault_full_ring);
  module.attr("Fault") = flag("Fault", faults, py::arg("module") = "trephine");

  py::class_<PyEvent>(module, "Event", "An event of the operation, such as a torn structure.")
      .def_readonly("tick", &PyEvent::tick)
      .def_readonly("hand", &PyEvent::hand)
      .def_readonly("position", &PyEvent::position, "World, mm.")
      .def_readonly("name", &PyEvent::name, "Kind of the event, such as \"structure-torn\".")
      .def_readonly("fields", &PyEvent::fields, "Values of the event.")
      .def("__repr__", [](const PyEvent& e) {
        return "<trephine.Event " + e.name + " at tick " + std::to_string(e.tick) + ">";
      });

  py::class_<PySurface>(module, "Surface",
                        "Triangles in the world frame, counter-clockwise as viewed from outside.")
      .def_readonly("vertices", &PySurface::vertices, "(V, 3), mm.")
      .def_readonly("triangles", &PySurface::triangles, "(T, 3), indices of vertices.");
}

}  // namespace trephine::python
