#include "data-tools/files/sensitive_names.h"

#include <algorithm>
#include <mutex>
#include <set>

namespace trephine::data_tools {

namespace {
struct Names {
  std::mutex mutex;
  std::set<std::string> all;
};
Names& names() {
  static Names all;
  return all;
}
constexpr std::size_t k_max = 200'000;
}  // namespace

void record_sensitive_name(const std::string& name) {
  const std::lock_guard lock(names().mutex);
  if (names().all.size() < k_max) names().all.insert(name);
  for (std::size_t begin = 0; begin < name.size() && names().all.size() < k_max;) {
    const std::size_t end = std::min(name.find('/', begin), name.size());
    const std::string part = name.substr(begin, end - begin);
    // Short and common parts also occur in our own texts; they are recorded only within whole names.
    if (part.size() > 2 && part != "DICOM" && part != "DICOMDIR") names().all.insert(part);
    begin = end + 1;
  }
}

std::vector<std::string> sensitive_names() {
  const std::lock_guard lock(names().mutex);
  return {names().all.begin(), names().all.end()};
}

}  // namespace trephine::data_tools
