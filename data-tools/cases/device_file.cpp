#include "data-tools/cases/device_file.h"

#include <filesystem>

#include "data-tools/cases/toml_reader_impl.h"
#include "data-tools/files/atomic_file.h"

namespace trephine::data_tools {

Result<std::optional<DeviceSettings>> read_device_settings(const std::string& path) {
  // A link to a missing file is reported by read_toml_text().
  std::error_code missing;
  if (!std::filesystem::exists(std::filesystem::symlink_status(path, missing)))
    return std::optional<DeviceSettings>();
  const std::string where = file_name(path);
  const auto text = read_toml_text(path, where, "list of devices");
  if (!text) return text.error();
  const auto top = parse_toml(text.value(), where, "list of devices");
  if (!top) return top.error();
  TomlReader reader(where);
  const toml::table& t = reader.table(top.value(), {"device", "pedal", "scale"});
  constexpr double k_least = 0.1, k_most = 10;
  DeviceSettings settings;
  settings.device = reader.text(t, "device").value_or("");
  settings.pedal = reader.text(t, "pedal").value_or("");
  settings.scale = reader.number(t, "scale", k_least, k_most).value_or(1);
  if (Status error = reader.error()) return *error;
  return std::optional(std::move(settings));
}

}  // namespace trephine::data_tools
