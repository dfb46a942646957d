#include "apps/python/arrays.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace trephine::python {

using glm::dvec3;

namespace {

/// The class trephine.Error. It is never destroyed, since a static object would outlive the interpreter.
py::object& error_class() {
  static py::object* const k_class = new py::object();
  return *k_class;
}

Error argument_error(const char* what, const char* name, const std::string& found,
                     const std::string& expected, const char* remedy) {
  return {.what = what, .where = name, .found = found, .expected = expected, .remedy = remedy};
}

std::string shape_text(const py::array& array) {
  std::string text = "an array of shape (";
  for (py::ssize_t i = 0; i < array.ndim(); ++i) {
    if (i > 0) text += ", ";
    text += std::to_string(array.shape(i));
  }
  text += ')';
  return text;
}

std::string number_text(double value) {
  char text[32];
  const auto [end, error] = std::to_chars(std::begin(text), std::end(text), value);
  return std::string(text, end);
}

std::string quoted(const std::string& text) {
  std::string result(1, '"');
  for (const char c : text) {
    if (c == '"' || c == '\\') result += '\\';
    result += c;
  }
  result += '"';
  return result;
}

/// Returns the value as Python's own bool, int or float, if it is a scalar of NumPy.
py::object plain_scalar(const py::handle& value) {
  const py::object object = py::reinterpret_borrow<py::object>(value);
  return py::isinstance(object, py::module_::import("numpy").attr("generic")) ? object.attr("item")()
                                                                              : object;
}

std::string word_of(const std::string& name, const py::handle& any) {
  const py::object value = plain_scalar(any);
  if (py::isinstance<py::bool_>(value)) return value.cast<bool>() ? "yes" : "no";
  if (py::isinstance<py::str>(value)) return quoted(value.cast<std::string>());
  if (py::isinstance<py::int_>(value)) return std::string(py::str(value));
  if (py::isinstance<py::float_>(value)) return number_text(value.cast<double>());
  if (py::isinstance<py::bytes>(value) ||
      (!py::isinstance<py::sequence>(value) && !py::isinstance<py::array>(value)))
    raise(argument_error("a parameter has the wrong type", name.c_str(),
                         std::string(py::str(py::type::of(value))),
                         "a number, True or False, a text, or a sequence of numbers or points",
                         "omit the parameter for its default"));
  // A sequence of numbers, or of points.
  std::string words;
  for (const py::handle& item : value) {
    const bool is_list = (py::isinstance<py::sequence>(item) || py::isinstance<py::array>(item)) &&
                         !py::isinstance<py::str>(item);
    if (!words.empty()) words += is_list ? ';' : ',';
    words += word_of(name, item);
  }
  return words;
}

}  // namespace

void register_error(py::module_& module) {
  py::dict body;
  body["__doc__"] =
      "Raised if an input is invalid or not allowed. `what` is the problem, `where` the file or argument, "
      "`found` and `expected` the values, `remedy` the correction. `is_refusal`: the state does not allow a "
      "valid command.";
  body["is_refusal"] = false;
  error_class() =
      py::reinterpret_steal<py::object>(PyErr_NewException("trephine.Error", PyExc_ValueError, body.ptr()));
  module.attr("Error") = error_class();
  py::register_exception_translator([](std::exception_ptr pointer) {
    try {
      if (pointer) std::rethrow_exception(pointer);
    } catch (const PythonError& raised) {
      const Error& error = raised.error;
      py::object instance = error_class()(error.message());
      instance.attr("what") = error.what;
      instance.attr("where") = error.where;
      instance.attr("found") = error.found;
      instance.attr("expected") = error.expected;
      instance.attr("remedy") = error.remedy;
      instance.attr("is_refusal") = error.kind == ErrorKind::refused;
      PyErr_SetObject(error_class().ptr(), instance.ptr());
    }
  });
}

void raise_out_of_memory(const char* name) {
  PyErr_Clear();
  raise(argument_error("an array does not fit in memory", name, "no free memory for a copy",
                       "a smaller array", "pass the data in parts"));
}

dvec3 vector_of(const py::handle& value, const char* name) {
  const auto array = py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(value);
  if (!array || array.ndim() != 1 || array.shape(0) != 3) {
    PyErr_Clear();
    raise(argument_error("an argument is not a point or direction", name,
                         py::str(py::str(value)[py::slice(0, 80, 1)]), "three numbers (x, y, z)",
                         "pass a list, tuple or array of three numbers"));
  }
  return {array.at(0), array.at(1), array.at(2)};
}

glm::ivec3 indices_of(const py::handle& value, const char* name) {
  const dvec3 v = vector_of(value, name);
  constexpr double k_most = 1 << 20;
  for (int a = 0; a < 3; ++a)
    if (v[a] != std::floor(v[a]) || !(std::abs(v[a]) <= k_most))
      raise(argument_error("an index is not an integer in range", name, number_text(v[a]),
                           "indices of voxels (x, y, z), of at most 2^20", "pass integers in this range"));
  return glm::ivec3(v);
}

std::string text_of(const py::handle& value, const std::string& name, const char* expected) {
  const bool is_path = py::hasattr(value, "__fspath__");
  if (!py::isinstance<py::str>(value) && !is_path) raise_wrong_type(value, name, expected);
  return (is_path ? py::str(value.attr("__fspath__")()) : py::str(value)).cast<std::string>();
}

py::array_t<std::uint32_t, py::array::c_style> buttons_of(const py::handle& value,
                                                          const std::vector<py::ssize_t>& shape) {
  const std::string expected =
      shape.size() == 3 ? "one integer, or an array of integers of shape (" + std::to_string(shape[0]) +
                              ", " + std::to_string(shape[1]) + "), of at least 0"
                        : "one integer, or " + std::to_string(shape[0]) + " integers, of at least 0";
  py::array any = py::array::ensure(value);
  if (!any) PyErr_Clear();
  const char kind = any ? any.dtype().kind() : 'O';
  if (kind != 'i' && kind != 'u' && kind != 'b')
    raise(argument_error("buttons are not integers", "buttons",
                         any ? std::string(py::str(any.dtype())) : "no array", expected,
                         "pass 1 to activate the tool, otherwise 0"));
  const bool is_same = static_cast<std::size_t>(any.ndim()) + 1 == shape.size() &&
                       std::equal(any.shape(), any.shape() + any.ndim(), shape.begin());
  if (any.ndim() != 0 && !is_same)
    raise(argument_error("the shapes of buttons and positions differ", "buttons", shape_text(any), expected,
                         "pass one number per pose"));
  if (any.size() > 0 && kind == 'i' && any.attr("min")().cast<long long>() < 0)
    raise(argument_error("a value of buttons is negative", "buttons", std::string(py::str(any.attr("min")())),
                         expected, "pass 0 or 1"));
  if (any.size() > 0 && any.attr("max")().cast<unsigned long long>() > 0xffffffff)
    raise(argument_error("a value of buttons is too large", "buttons",
                         std::string(py::str(any.attr("max")())), "less than 2^32", "use bits 0 to 31"));
  return py::array_t<std::uint32_t, py::array::c_style | py::array::forcecast>::ensure(any);
}

py::tuple tuple_of(const dvec3& v) { return py::make_tuple(v.x, v.y, v.z); }
py::tuple tuple_of(const glm::dquat& q) { return py::make_tuple(q.w, q.x, q.y, q.z); }

py::array_t<double, py::array::c_style> doubles_of(const py::handle& value, const char* name, int width,
                                                   std::vector<py::ssize_t>& shape) {
  const std::string expected = "an array of numbers of shape (N, " + std::to_string(width) + ") or (T, H, " +
                               std::to_string(width) + ")";
  py::array any = py::array::ensure(value);
  if (!any) {
    PyErr_Clear();
    raise(argument_error("an argument is not an array", name, std::string(py::str(py::type::of(value))),
                         expected, "pass a NumPy array"));
  }
  const char kind = any.dtype().kind();
  if ((kind != 'f' && kind != 'i' && kind != 'u') || any.ndim() < 2 || any.ndim() > 3 ||
      any.shape(any.ndim() - 1) != width)
    raise(argument_error("an array has the wrong shape or type", name,
                         shape_text(any) + " of " + std::string(py::str(any.dtype())), expected,
                         "pass one row per tick, or with several hands one per tick and hand"));
  auto array = py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(any);
  if (!array) raise_out_of_memory(name);
  shape.assign(array.shape(), array.shape() + array.ndim());
  return py::array_t<double, py::array::c_style>(array);
}

std::string words_of(const py::kwargs& keywords) {
  std::string words;
  for (const auto& [name, value] : keywords) {
    if (!words.empty()) words += ' ';
    words += name.cast<std::string>();
    words += '=';
    words += word_of(name.cast<std::string>(), value);
  }
  return words;
}

py::dict fields_of(const sim::Value& value) {
  py::dict result;
  if (value.is_empty()) return result;
  sim::Value copy = value;  // pointer_in() needs an object that is not const
  for (const sim::Field& field : value.schema().fields) {
    const auto to_object = [&](auto* pointer) -> py::object {
      using T = std::remove_pointer_t<decltype(pointer)>;
      if constexpr (std::is_same_v<T, dvec3>) {
        return tuple_of(*pointer);
      } else if constexpr (std::is_same_v<T, sim::Id>) {
        return py::int_(pointer->value);
      } else if constexpr (std::is_same_v<T, std::uint8_t>) {
        return *pointer < field.info.choices.size()
                   ? py::object(py::str(std::string(field.info.choices[*pointer])))
                   : py::object(py::int_(*pointer));
      } else if constexpr (std::is_same_v<T, std::vector<dvec3>>) {
        py::list list;
        for (const dvec3& v : *pointer) list.append(tuple_of(v));
        return list;
      } else if constexpr (std::is_same_v<T, std::vector<sim::Id>>) {
        py::list list;
        for (const sim::Id& id : *pointer) list.append(id.value);
        return list;
      } else if constexpr (std::is_same_v<T, std::vector<double>>) {
        py::list list;
        for (const double x : *pointer) list.append(x);
        return list;
      } else {
        return py::cast(*pointer);
      }
    };
    result[py::str(std::string(field.name))] = std::visit(to_object, field.pointer_in(copy.data()));
  }
  return result;
}

}  // namespace trephine::python
