// A case.toml of any bytes.
#include <cstdint>
#include <cstdlib>

#include "data-tools/case_folder.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace trephine;
  const auto read = data_tools::parse_case(std::string(reinterpret_cast<const char*>(data), size), "fuzz");
  if (!read) return 0;
  // What was understood can be written and is understood again.
  const auto again =
      data_tools::parse_case(data_tools::case_text(read.value(), !read.value().label_names.empty()), "again");
  if (!again || again.value().structures.size() != read.value().structures.size()) std::abort();
  return 0;
}
