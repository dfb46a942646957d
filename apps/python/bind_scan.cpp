#include "apps/python/bind_scan.h"

#include <cstring>
#include <map>

#include "data-tools/formats/open_volume.h"
#include "data-tools/phantoms/phantoms.h"

namespace trephine::python {

using glm::dvec3;
using glm::ivec3;

namespace {

template <class T>
py::array view_of(const T* data, const ivec3& size, py::object owner) {
  const auto step = static_cast<py::ssize_t>(sizeof(T));
  py::array array(py::dtype::of<T>(), {size.z, size.y, size.x}, {step * size.x * size.y, step * size.x, step},
                  data, std::move(owner));
  array.attr("flags").attr("writeable") = false;
  return array;
}

Scan scan_of(const py::object& any, const py::object& spacing, const py::object& origin, bool is_hounsfield) {
  if (!py::isinstance<py::array>(any)) raise_wrong_type(any, "voxels", "a NumPy array of int16");
  const auto voxels = py::cast<py::array>(any);
  if (voxels.ndim() != 3 || !py::isinstance<py::array_t<std::int16_t>>(voxels))
    raise({.what = "the array cannot be used as a scan",
           .where = "voxels",
           .found = std::to_string(voxels.ndim()) + " dimensions of " + std::string(py::str(voxels.dtype())),
           .expected = "shape (z, y, x) of int16",
           .remedy = "round the values, limit them to -32768 to 32767, and convert them to numpy.int16"});
  constexpr py::ssize_t k_longest = 32768;
  for (py::ssize_t a = 0; a < 3; ++a)
    if (voxels.shape(a) < 1 || voxels.shape(a) > k_longest)
      raise({.what = "the size of a scan is out of range",
             .where = "voxels",
             .found = std::to_string(voxels.shape(a)),
             .expected = "1 to 32768 along each axis",
             .remedy = "crop or resample the array"});
  const auto array = py::array_t<std::int16_t, py::array::c_style | py::array::forcecast>::ensure(voxels);
  if (!array) raise_out_of_memory("voxels");
  const ivec3 size(static_cast<int>(array.shape(2)), static_cast<int>(array.shape(1)),
                   static_cast<int>(array.shape(0)));
  const volume::Frame frame =
      value_of(volume::Frame::from_spacing(vector_of(origin, "origin"), vector_of(spacing, "spacing")));
  volume::Volume scan = value_of(volume::make_volume(size, frame));
  std::memcpy(scan.voxels.data(), array.data(), scan.voxels.bytes());
  scan.is_hounsfield = is_hounsfield;
  return {.volume = std::make_shared<const volume::Volume>(std::move(scan))};
}

Scan phantom(const std::string& name, const py::object& spacing, double psf, std::uint64_t seed,
             const py::kwargs& parameters) {
  data_tools::PhantomOptions options;
  if (!spacing.is_none()) options.spacing_mm = vector_of(spacing, "spacing");
  options.psf_sigma_voxels = psf;
  options.seed = seed;
  for (const auto& [key, value] : parameters)
    options.parameters[key.cast<std::string>()] =
        argument<double>(value, key.cast<std::string>(), "a number");
  py::gil_scoped_release release;
  return {.volume = std::make_shared<const volume::Volume>(value_of(data_tools::make_phantom(name, options))),
          .phantom = seed == 1 && options.parameters.empty() ? name : std::string()};
}

/// Converts an array of points between the volume frame and the world.
template <class Convert>
py::array_t<double> converted(const py::handle& points, const char* name, const Convert& convert) {
  std::vector<py::ssize_t> shape;
  const auto input = doubles_of(points, name, 3, shape);
  py::array_t<double> output(shape);
  const double* in = input.data();
  double* out = output.mutable_data();
  for (py::ssize_t i = 0; i + 2 < input.size(); i += 3) {
    const dvec3 p = convert(dvec3(in[i], in[i + 1], in[i + 2]));
    out[i] = p.x, out[i + 1] = p.y, out[i + 2] = p.z;
  }
  return output;
}

}  // namespace

py::array voxels_of(const volume::Volume& scan, py::object owner) {
  return view_of(scan.voxels.data(), scan.size, std::move(owner));
}

void bind_scan(py::module_& module) {
  py::class_<Scan>(
      module, "Scan",
      "A scan, or a phantom. Arrays are (z, y, x), points (x, y, z) in mm: x to the patient's left, y to the "
      "back, z up (LPS).")
      .def(
          py::init(&scan_of), py::arg("voxels"), py::arg("spacing"),
          py::arg("origin") = py::make_tuple(0, 0, 0), py::arg("hounsfield") = false,
          "Copies an array of int16 of shape (z, y, x). `spacing`: mm along x, y, z. `origin`: world position "
          "of the centre of voxel (0, 0, 0), mm. `hounsfield`: True if the values are Hounsfield units, which "
          "X-rays and drilling by bone density need.")
      .def_static(
          "phantom", &phantom, py::arg("name"), py::arg("spacing") = py::none(), py::arg("psf") = 0.0,
          py::arg("seed") = 1,
          "Makes a phantom: \"head\", \"spine\", or an analytic one such as \"sphere\". `spacing`: mm along "
          "x, y, z. `psf`: sigma of the scanner's blur, voxels. `seed`: seed of the random numbers. Other "
          "keywords are parameters of the phantom.")
      .def(
          "save",
          [](const Scan& scan, const py::object& path) {
            const std::string file = text_of(path, "path", "the path of a file");
            py::gil_scoped_release unlocked;
            check(data_tools::write_volume(file, *scan.volume));
          },
          py::arg("path"), "Writes the scan, for example as .nrrd, .mha or .nii.gz.")
      .def_property_readonly(
          "array", [](py::object self) { return voxels_of(*self.cast<const Scan&>().volume, self); },
          "Intensities, a read-only view of shape (z, y, x) without a copy. It keeps the scan alive.")
      .def_property_readonly(
          "labels",
          [](py::object self) -> py::object {
            const volume::Volume& scan = *self.cast<const Scan&>().volume;
            if (scan.labels.is_empty()) return py::none();
            return view_of(scan.labels.data(), scan.size, self);
          },
          "Labels, a read-only view of shape (z, y, x); None without labels.")
      .def_property_readonly(
          "label_names", [](const Scan& scan) { return py::cast(scan.volume->label_names); },
          "Names of the labels; the index is the number in `labels`.")
      .def_property_readonly(
          "shape",
          [](const Scan& s) { return py::make_tuple(s.volume->size.z, s.volume->size.y, s.volume->size.x); },
          "Number of voxels (z, y, x).")
      .def_property_readonly(
          "spacing", [](const Scan& s) { return tuple_of(s.volume->frame.spacing()); },
          "Distances between voxel centres along x, y, z, mm.")
      .def_property_readonly(
          "origin", [](const Scan& s) { return tuple_of(s.volume->frame.origin()); },
          "World position of the centre of voxel (0, 0, 0), mm.")
      .def_property_readonly(
          "is_hounsfield", [](const Scan& s) { return s.volume->is_hounsfield; },
          "True if intensities are Hounsfield units.")
      .def(
          "world",
          [](const Scan& s, const py::handle& points) {
            return converted(points, "points",
                             [&](const dvec3& p) { return s.volume->frame.world_from_volume(p); });
          },
          py::arg("points"), "World positions (N, 3), mm, of voxel indices (N, 3) in the order x, y, z.")
      .def(
          "voxel",
          [](const Scan& s, const py::handle& points) {
            return converted(points, "points",
                             [&](const dvec3& p) { return s.volume->frame.volume_from_world(p); });
          },
          py::arg("points"), "Voxel indices (N, 3) in the order x, y, z of world positions (N, 3), mm.")
      .def("__reduce__",
           [](const Scan&) -> py::object {
             throw py::type_error(
                 "scans cannot be pickled; save `array`, `spacing` and `origin`, or pass the path");
           })
      .def("__repr__", [](const Scan& one) {
        const volume::Volume& s = *one.volume;
        const dvec3 mm = s.frame.spacing();
        char text[128];
        std::snprintf(text, sizeof text, "<trephine.Scan %d x %d x %d voxels of %.3g x %.3g x %.3g mm>",
                      s.size.x, s.size.y, s.size.z, mm.x, mm.y, mm.z);
        return std::string(text);
      });
}

}  // namespace trephine::python
