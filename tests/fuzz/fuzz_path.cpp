// Fuzzes path files with any bytes.
#include <cstdint>
#include <cstdlib>
#include <sstream>

#include "haptics/device/pose_path.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace trephine;
  std::istringstream in(std::string(reinterpret_cast<const char*>(data), size));
  const auto read = haptics::PosePath::read_csv(in, "fuzz");
  if (!read) return 0;
  // An accepted path can be sampled and written, and the written path is read again with as many samples.
  const haptics::PosePath& path = read.value();
  (void)path.at(path.start_time());
  (void)path.at(0.5 * (path.start_time() + path.end_time()));
  std::ostringstream out;
  path.write_csv(out);
  std::istringstream again(out.str());
  const auto second = haptics::PosePath::read_csv(again, "again");
  if (!second || second.value().samples().size() != path.samples().size()) std::abort();
  return 0;
}
