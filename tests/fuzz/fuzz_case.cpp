// Fuzzes case.toml and scripts with any bytes.
#include <cstdint>
#include <cstdlib>

#include "data-tools/cases/case_folder.h"
#include "data-tools/cases/script_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace trephine;
  (void)data_tools::parse_script(std::string(reinterpret_cast<const char*>(data), size), "fuzz");
  const auto read = data_tools::parse_case(std::string(reinterpret_cast<const char*>(data), size), "fuzz");
  if (!read) return 0;
  // An accepted case can be written and is accepted again.
  const auto again =
      data_tools::parse_case(data_tools::case_text(read.value(), !read.value().label_names.empty()), "again");
  if (!again || again.value().structures.size() != read.value().structures.size()) std::abort();
  return 0;
}
