#include "data-tools/case_folder.h"

#include <charconv>
#include <cmath>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <toml.hpp>
#include <unistd.h>

#include "data-tools/atomic_file.h"

namespace trephine::data_tools {

namespace fs = std::filesystem;
using volume::Error;
using volume::Result;
using volume::Status;

namespace {

constexpr const char* k_plan_file = "case.toml";
constexpr const char* k_volume_file = "volume.mha";
constexpr const char* k_labels_file = "labels.mha";

/// Reads tables whose keys are all known; the first fault stays.
class Reader {
 public:
  explicit Reader(std::string where) : where_(std::move(where)) {}

  /// The table at `value`, every key of which is in `known`.
  const toml::table& table(const toml::value& value, const std::set<std::string>& known) {
    static const toml::table k_empty;
    if (!value.is_table()) return fail(value, "this is no table", "", "a table"), k_empty;
    for (const auto& [key, v] : value.as_table())
      if (!known.contains(key)) {
        std::string list;
        for (const std::string& k : known) list += (list.empty() ? "" : ", ") + k;
        fail(v, "there is no such key", key, "one of " + list, "remove the line, or correct the spelling");
      }
    return value.as_table();
  }
  std::optional<double> number(const toml::table& t, const std::string& key, double low, double high) {
    const auto it = t.find(key);
    if (it == t.end()) return std::nullopt;
    double v = NAN;
    if (it->second.is_integer()) v = static_cast<double>(it->second.as_integer());
    if (it->second.is_floating()) v = it->second.as_floating();
    if (v >= low && v <= high) return v;
    fail(it->second, "the value of " + key + " is out of range", text_of(it->second),
         "a number from " + text_of(low) + " to " + text_of(high));
    return std::nullopt;
  }
  std::optional<std::string> text(const toml::table& t, const std::string& key) {
    const auto it = t.find(key);
    if (it == t.end()) return std::nullopt;
    if (it->second.is_string() && !it->second.as_string().str.empty() &&
        it->second.as_string().str.size() <= 200)
      return it->second.as_string().str;
    fail(it->second, "the value of " + key + " is no text", text_of(it->second),
         "\"text\" of 1 to 200 characters");
    return std::nullopt;
  }
  std::optional<bool> claim(const toml::table& t, const std::string& key) {
    const auto it = t.find(key);
    if (it == t.end()) return std::nullopt;
    if (it->second.is_boolean()) return it->second.as_boolean();
    fail(it->second, "the value of " + key + " is neither true nor false", text_of(it->second),
         "true or false");
    return std::nullopt;
  }
  std::optional<glm::dvec3> point(const toml::table& t, const std::string& key) {
    const auto it = t.find(key);
    if (it == t.end()) return std::nullopt;
    glm::dvec3 p(NAN);
    if (it->second.is_array() && it->second.as_array().size() == 3)
      for (int a = 0; a < 3; ++a) {
        const toml::value& v = it->second.as_array()[static_cast<std::size_t>(a)];
        if (v.is_floating()) p[a] = v.as_floating();
        if (v.is_integer()) p[a] = static_cast<double>(v.as_integer());
      }
    if (std::abs(p.x) < 1e6 && std::abs(p.y) < 1e6 && std::abs(p.z) < 1e6) return p;
    fail(it->second, "the value of " + key + " is no point", text_of(it->second), "[x, y, z] in mm, LPS");
    return std::nullopt;
  }
  /// The tables of an array of tables; none when the key is absent.
  std::vector<const toml::value*> tables(const toml::table& t, const std::string& key) {
    std::vector<const toml::value*> result;
    const auto it = t.find(key);
    if (it == t.end()) return result;
    if (!it->second.is_array())
      return fail(it->second, key + " is no list of tables", "", "[[" + key + "]]"), result;
    for (const toml::value& v : it->second.as_array()) result.push_back(&v);
    return result;
  }
  void fail(const toml::value& at, std::string what, std::string found, std::string expected,
            std::string remedy = "") {
    if (error_) return;
    error_ = Error{std::move(what), where_ + ", line " + std::to_string(at.location().line()),
                   std::move(found), std::move(expected), std::move(remedy)};
  }
  const std::optional<Error>& error() const { return error_; }

  static std::string text_of(double v) {
    char text[40];
    return std::string(text, std::to_chars(text, text + sizeof text, v).ptr);
  }

 private:
  static std::string text_of(const toml::value& v) {
    std::ostringstream out;
    out << v;
    return out.str().substr(0, 80);
  }

  std::string where_;
  std::optional<Error> error_;
};

CaseStructure read_structure(Reader& reader, const toml::value& value, std::size_t label_count) {
  const toml::table& t = reader.table(value, {"name", "low", "high", "label", "touchable", "forbidden",
                                              "stiffness", "damping", "static_friction", "dynamic_friction"});
  CaseStructure s;
  const auto name = reader.text(t, "name");
  if (!name) reader.fail(value, "a structure has no name", "", "name = \"bone\"");
  s.shape.name = name.value_or("");
  const auto low = reader.number(t, "low", -1e6, 1e6), high = reader.number(t, "high", -1e6, 1e6);
  const auto label = reader.number(t, "label", 1, 255);
  s.shape.low = low.value_or(-std::numeric_limits<double>::infinity());
  s.shape.high = high.value_or(std::numeric_limits<double>::infinity());
  if (label) {
    s.shape.label = static_cast<int>(*label);
    if (low || high || *label != s.shape.label)
      reader.fail(value, "a structure is either a window or a label", "both", "low and high, or label");
    if (static_cast<std::size_t>(s.shape.label) >= std::max<std::size_t>(label_count, 1))
      reader.fail(value, "there is no such label", std::to_string(s.shape.label),
                  "a label that the case has: see names under [labels]");
  } else if (!low && !high) {
    reader.fail(value, "it is not said what the structure is", s.shape.name, "low, high or label");
  } else if (s.shape.low > s.shape.high) {
    reader.fail(value, "the window's lower end lies above its upper end", "", "low <= high", "swap them");
  }
  s.is_touchable = reader.claim(t, "touchable").value_or(true);
  s.is_forbidden = reader.claim(t, "forbidden").value_or(false);
  s.material.stiffness = reader.number(t, "stiffness", 0, 100);
  s.material.damping = reader.number(t, "damping", 0, 1);
  s.material.static_friction = reader.number(t, "static_friction", 0, 10);
  s.material.dynamic_friction = reader.number(t, "dynamic_friction", 0, 10);
  return s;
}

CaseTrajectory read_trajectory(Reader& reader, const toml::value& value) {
  const toml::table& t = reader.table(value, {"name", "entry", "target", "diameter"});
  CaseTrajectory result;
  const auto name = reader.text(t, "name");
  const auto entry = reader.point(t, "entry"), target = reader.point(t, "target");
  if (!name || !entry || !target)
    reader.fail(value, "a trajectory is not complete", "", "name, entry = [x, y, z] and target = [x, y, z]");
  result.name = name.value_or("");
  result.entry_world = entry.value_or(glm::dvec3(0));
  result.target_world = target.value_or(glm::dvec3(0));
  result.diameter = reader.number(t, "diameter", 0, 100).value_or(0);
  return result;
}

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  }
  return out + '"';
}

}  // namespace

bool is_case_folder(const std::string& path) {
  std::error_code error;
  return fs::is_regular_file(fs::path(path) / k_plan_file, error);
}

namespace {

/// The line of the first byte that TOML does not know: control characters and what is no UTF-8. The parser
/// behind (toml11 3.7) reads past its buffer on some of these.
std::optional<int> first_foreign_line(const std::string& text) {
  int line = 1;
  for (std::size_t i = 0; i < text.size();) {
    const auto byte = static_cast<unsigned char>(text[i]);
    if (byte == '\n') ++line;
    if (byte < 0x80) {
      if ((byte < 0x20 && byte != '\t' && byte != '\n' && byte != '\r') || byte == 0x7f) return line;
      ++i;
      continue;
    }
    // UTF-8: lead byte, then what it promises (RFC 3629, without overlong forms and surrogates).
    const std::size_t more = byte >= 0xc2 && byte <= 0xdf   ? 1
                             : byte >= 0xe0 && byte <= 0xef ? 2
                             : byte >= 0xf0 && byte <= 0xf4 ? 3
                                                            : 0;
    if (more == 0 || i + more >= text.size()) return line;
    std::uint32_t code = byte & (0x3fu >> more);
    for (std::size_t k = 1; k <= more; ++k) {
      const auto next = static_cast<unsigned char>(text[i + k]);
      if ((next & 0xc0) != 0x80) return line;
      code = code << 6 | (next & 0x3fu);
    }
    if ((more == 2 && (code < 0x800 || (code >= 0xd800 && code < 0xe000))) ||
        (more == 3 && (code < 0x10000 || code > 0x10ffff)))
      return line;
    i += more + 1;
  }
  return std::nullopt;
}

}  // namespace

Result<CasePlan> parse_case(const std::string& text, const std::string& where) {
  if (const std::optional<int> line = first_foreign_line(text))
    return Error{"the case is no text", where + ", line " + std::to_string(*line),
                 "a byte that is no UTF-8 or a control character", "plain text in UTF-8", "save it as UTF-8"};
  toml::value root;
  try {
    std::istringstream in(text);
    root = toml::parse(in, where);
  } catch (const toml::exception& e) {
    return Error{"the case is no TOML", where + ", line " + std::to_string(e.location().line()), "",
                 "key = value, [table] and [[list]]", "see docs/file-formats.md"};
  } catch (const std::exception&) {
    return Error{"the case is no TOML", where, "", "key = value, [table] and [[list]]",
                 "see docs/file-formats.md"};
  }
  Reader reader(where);
  const toml::table& top = reader.table(
      root, {"schema", "name", "modality", "hounsfield", "labels", "structures", "trajectories"});
  // The schema first: a newer case has keys that are no mistakes.
  const auto schema = top.find("schema");
  if (schema == top.end() || !schema->second.is_integer())
    return Error{"the case does not say its schema", where, "",
                 "schema = " + std::to_string(CasePlan::k_schema), ""};
  if (schema->second.as_integer() > CasePlan::k_schema)
    return Error{"the case was written by a newer trephine", where,
                 "schema " + std::to_string(schema->second.as_integer()),
                 "schema " + std::to_string(CasePlan::k_schema) + " or older", "open it with that version"};
  if (schema->second.as_integer() < 1)
    reader.fail(schema->second, "there is no such schema", "", "schema = 1");
  CasePlan plan;
  const auto name = reader.text(top, "name");
  if (!name) reader.fail(root, "the case has no name", "", "name = \"...\"");
  plan.name = name.value_or("");
  plan.modality = reader.text(top, "modality").value_or("");
  plan.is_hounsfield = reader.claim(top, "hounsfield").value_or(false);
  if (const auto labels = top.find("labels"); labels != top.end()) {
    const toml::table& t = reader.table(labels->second, {"names"});
    plan.label_names.emplace_back("background");
    const auto names = t.find("names");
    if (names == t.end() || !names->second.is_array() || names->second.as_array().size() > 255) {
      reader.fail(labels->second, "the labels have no names", "",
                  "names = [\"skull\", ...] for labels 1, 2, ...");
    } else {
      for (const toml::value& v : names->second.as_array()) {
        if (!v.is_string()) reader.fail(v, "a label's name is no text", "", "\"text\"");
        plan.label_names.push_back(v.is_string() ? v.as_string().str : "");
      }
    }
  }
  for (const toml::value* v : reader.tables(top, "structures"))
    plan.structures.push_back(read_structure(reader, *v, plan.label_names.size()));
  for (const toml::value* v : reader.tables(top, "trajectories"))
    plan.trajectories.push_back(read_trajectory(reader, *v));
  if (plan.structures.empty())
    reader.fail(root, "the case has no structure", "", "at least one [[structures]]");
  if (reader.error()) return *reader.error();
  return plan;
}

Result<OpenedCase> open_case(const std::string& path, const OpenOptions& options) {
  const std::string where = file_name(path) + "/" + k_plan_file;
  std::ifstream file(fs::path(path) / k_plan_file, std::ios::binary);
  if (!file) return Error{"the case cannot be read", where, "", "a folder with case.toml", ""};
  std::ostringstream text;
  text << file.rdbuf();
  if (text.str().size() > 1 << 20)
    return Error{"the case is too large", where, "", "a case.toml below 1 MB", ""};
  Result<CasePlan> plan = parse_case(text.str(), where);
  if (!plan) return plan.error();
  Result<OpenedVolume> scan = open_volume((fs::path(path) / k_volume_file).string(), options);
  if (!scan) return scan.error();
  OpenedCase result{std::move(plan).value(), std::move(scan).value()};
  volume::Volume& v = result.scan.volume;
  v.is_hounsfield = result.plan.is_hounsfield;
  result.scan.format = "case";
  result.scan.modality = result.plan.modality;
  result.scan.notices.clear();  // of what the image file left open; the plan says it
  if (result.plan.label_names.empty()) return result;

  OpenOptions plain = options;
  plain.maps_padding = false;
  Result<OpenedVolume> labels = open_volume((fs::path(path) / k_labels_file).string(), plain);
  if (!labels) return labels.error();
  const volume::Volume& l = labels.value().volume;
  const std::string labels_where = file_name(path) + "/" + k_labels_file;
  if (l.size != v.size)
    return Error{"the labels lie on another grid than the scan", labels_where, "", "the same size", ""};
  v.labels = volume::Buffer<std::uint8_t>(v.voxels.size());
  for (std::size_t i = 0; i < v.voxels.size(); ++i) {
    if (l.voxels[i] < 0 || static_cast<std::size_t>(l.voxels[i]) >= result.plan.label_names.size())
      return Error{"a label has no name", labels_where, std::to_string(l.voxels[i]),
                   "0 to " + std::to_string(result.plan.label_names.size() - 1),
                   "name it under [labels] in case.toml"};
    v.labels[i] = static_cast<std::uint8_t>(l.voxels[i]);
  }
  v.label_names = result.plan.label_names;
  return result;
}

std::string case_text(const CasePlan& plan, bool has_labels) {
  std::string out = "# A case of trephine. Every key is described in docs/file-formats.md.\n";
  const auto line = [&out](const char* key, const std::string& value) {
    out += std::string(key) + " = " + value + "\n";
  };
  const auto number = [&line](const char* key, double value) {
    const std::string text = Reader::text_of(value);
    line(key, text.find_first_of(".e") == std::string::npos ? text + ".0" : text);
  };
  const auto point = [&line](const char* key, const glm::dvec3& p) {
    line(key, "[" + Reader::text_of(p.x) + ", " + Reader::text_of(p.y) + ", " + Reader::text_of(p.z) + "]");
  };
  line("schema", std::to_string(CasePlan::k_schema));
  line("name", quoted(plan.name) + "  # chosen for the case, never a patient's");
  if (!plan.modality.empty()) line("modality", quoted(plan.modality));
  line("hounsfield", plan.is_hounsfield ? "true" : "false");
  if (has_labels) {
    out += "\n[labels]  # of labels.mha, from 1 up\nnames = [";
    for (std::size_t i = 1; i < plan.label_names.size(); ++i)
      out += (i > 1 ? ", " : "") + quoted(plan.label_names[i]);
    out += "]\n";
  }
  for (const CaseStructure& s : plan.structures) {
    out += "\n[[structures]]\n";
    line("name", quoted(s.shape.name));
    if (s.shape.is_label()) line("label", std::to_string(s.shape.label));
    if (!s.shape.is_label() && std::isfinite(s.shape.low)) number("low", s.shape.low);
    if (!s.shape.is_label() && std::isfinite(s.shape.high)) number("high", s.shape.high);
    line("touchable", s.is_touchable ? "true" : "false");
    if (s.is_forbidden) line("forbidden", "true");
    if (s.material.stiffness) number("stiffness", *s.material.stiffness);
    if (s.material.damping) number("damping", *s.material.damping);
    if (s.material.static_friction) number("static_friction", *s.material.static_friction);
    if (s.material.dynamic_friction) number("dynamic_friction", *s.material.dynamic_friction);
  }
  for (const CaseTrajectory& t : plan.trajectories) {
    out += "\n[[trajectories]]\n";
    line("name", quoted(t.name));
    point("entry", t.entry_world);
    point("target", t.target_world);
    if (t.diameter > 0) number("diameter", t.diameter);
  }
  return out;
}

Status write_case(const std::string& path, const CasePlan& plan, const volume::Volume& scan,
                  const Progress& progress) {
  const fs::path target = fs::path(path).has_filename() ? fs::path(path) : fs::path(path).parent_path();
  const std::string where = target.filename().string();
  std::error_code error;
  if (fs::exists(target, error))
    return Error{"there is something of that name already", where, "", "the name of a new folder",
                 "choose another name, or remove it first"};
  // What is written must be understood again.
  if (const Result<CasePlan> again =
          parse_case(case_text(plan, !scan.labels.is_empty()), where + "/" + k_plan_file);
      !again)
    return again.error();
  std::string made = target.string() + ".part-XXXXXX";
  if (mkdtemp(made.data()) == nullptr)
    return Error{"the case cannot be written",
                 where,
                 "",
                 "a folder that exists and can be written",
                 "check the spelling and the permissions",
                 volume::ErrorKind::missing_here};
  fs::permissions(made,
                  fs::perms::owner_all | fs::perms::group_read | fs::perms::group_exec |
                      fs::perms::others_read | fs::perms::others_exec,
                  error);
  const auto goes_on = [&progress](double share) { return !progress || progress(share); };
  const Error cancelled{
      "the import was interrupted; nothing was written", where, "", "", "", volume::ErrorKind::interrupted};
  const bool has_labels = !scan.labels.is_empty();
  const auto write = [&]() -> Status {
    if (!goes_on(0.1)) return cancelled;
    if (Status e = write_volume((fs::path(made) / k_volume_file).string(), scan)) return e;
    if (!goes_on(0.7)) return cancelled;
    if (has_labels)
      if (Status e = write_labels((fs::path(made) / k_labels_file).string(), scan)) return e;
    if (!goes_on(0.9)) return cancelled;
    if (Status e =
            write_file_atomically((fs::path(made) / k_plan_file).string(), case_text(plan, has_labels)))
      return e;
    fs::rename(made, target, error);
    if (error)
      return Error{"the case cannot be written",   where, error.message(), "", "",
                   volume::ErrorKind::missing_here};
    return std::nullopt;
  };
  Status status = write();
  if (status) fs::remove_all(made, error);
  return status;
}

}  // namespace trephine::data_tools
