#include "apps/python/open_operation.h"

#include <optional>

#include "apps/python/bind_scan.h"

namespace trephine::python {

namespace {

void warn(const std::string& text) {
  py::module_::import("warnings").attr("warn")(text, py::module_::import("builtins").attr("UserWarning"), 1);
}

OperationOptions options_of(const py::kwargs& keywords) {
  OperationOptions options;
  options.notice = [](const std::string& text) {
    py::gil_scoped_acquire locked;
    warn(text);
  };
  if (keywords.contains("hand") && keywords.contains("hands"))
    raise({.what = "hand and hands exclude each other",
           .where = "Operation.open",
           .remedy = "pass hand=Hand(...), or hands=[Hand(...), Hand(...)]"});
  constexpr const char* k_hand = "a trephine.Hand";
  for (const auto& [key, value] : keywords) {
    const auto name = key.cast<std::string>();
    if (name == "hands") {
      options.hands.clear();
      for (const auto& hand : argument<py::sequence>(value, name, "a list of trephine.Hand"))
        options.hands.push_back(argument<Hand>(hand, name, k_hand));
    } else if (name == "hand") {
      options.hands = {argument<Hand>(value, name, k_hand)};
    } else if (name == "iso") {
      if (!value.is_none()) options.iso = argument<double>(value, name, "a number");
    } else if (name == "window") {
      options.window = text_of(value, name, "a text such as \"300:3000\"");
    } else if (name == "label") {
      options.label = text_of(value, name, "the name of a label");
    } else if (name == "plan") {
      options.uses_plan = argument<bool>(value, name, "True or False");
    } else if (name == "rate") {
      options.rate_hz = argument<double>(value, name, "ticks per second");
    } else if (name == "smallest_burr") {
      if (!value.is_none()) options.smallest_burr = argument<double>(value, name, "mm");
    } else if (name == "record") {
      if (!value.is_none())
        options.recording = {text_of(value, name, "the path of a new file"), false, "python"};
      if (!value.is_none() && options.recording.file.empty())
        raise({.what = "the path of the session is empty",
               .where = "record",
               .expected = "the path of a new file",
               .remedy = "pass None to record nothing"});
    } else {
      raise({.what = "unknown option of an operation",
             .where = "Operation.open",
             .found = name,
             .expected = "hand, hands, iso, window, label, plan, rate, smallest_burr, record",
             .remedy = "use one of these keywords"});
    }
  }
  return options;
}

}  // namespace

SharedOperation open(const py::object& source, const py::kwargs& keywords) {
  OperationOptions options = options_of(keywords);
  if (py::isinstance<Scan>(source)) {
    const std::shared_ptr<const volume::Volume> scan = source.cast<const Scan&>().volume;
    options.phantom = source.cast<const Scan&>().phantom;
    py::gil_scoped_release unlocked;
    return std::make_shared<PyOperation>(value_of(Operation::open(scan, options)));
  }
  const std::string path = text_of(source, "source", "a path, \"head\", \"spine\" or a Scan");
  py::gil_scoped_release unlocked;
  return std::make_shared<PyOperation>(value_of(Operation::open(path, options)));
}

SharedOperation reopen(const py::object& session, const py::object& scan) {
  const std::string path = text_of(session, "session", "the path of a session");
  std::vector<std::shared_ptr<const volume::Volume>> volumes;
  std::string source;
  if (py::isinstance<Scan>(scan))
    volumes.push_back(scan.cast<const Scan&>().volume);
  else if (!scan.is_none())
    source = text_of(scan, "scan", "a path or a Scan");
  const auto opened = [&] {
    py::gil_scoped_release unlocked;
    return std::make_shared<PyOperation>(
        value_of(volumes.empty() ? Operation::reopen(path, source) : Operation::reopen(path, volumes)));
  }();
  if (!opened->with([](Operation& operation) { return operation.is_whole(); }))
    warn("the end of the session was lost; the part before the loss is available");
  return opened;
}

}  // namespace trephine::python
