// bench dicom: times to find all series of a folder and to read one series, compared with ITK and its GDCM
// readers on the same files.
#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "apps/bench/commands/bench_commands.h"
#include "apps/bench/peers.h"
#include "apps/bench/scenes/dicom_files.h"
#include "apps/bench/scenes/scratch.h"
#include "data-tools/formats/open_volume.h"
#include "volume/base/percentile.h"

namespace trephine::bench {

using namespace cli;

namespace fs = std::filesystem;

namespace {

constexpr int k_images = 25;  // per series, on a disk of many series

/// Returns a slice with as many attributes as a slice of a CT by GE: 197, and 34 in private sequences.
scenes::DicomFile usual_slice(const scenes::SliceSpec& slice) {
  scenes::DicomFile file = slice_file(slice);
  file.set(0x00080005, "CS", "ISO_IR 100").set(0x00080008, "CS", "ORIGINAL\\PRIMARY\\AXIAL");
  for (std::uint32_t i = 0; i < 85; ++i) file.set(0x00189000 + i, "LO", "some setting of the scanner");
  for (std::uint32_t i = 0; i < 84; ++i) file.set(0x00400300 + i, "SH", "VALUE");
  scenes::DicomFile item;
  for (std::uint32_t i = 0; i < 17; ++i) item.set(0x00291010 + i, "OB", std::string(60, 'x'));
  return file.set(0x00290010, "LO", "MAKER").set_items(0x00291001, {item, item});
}

/// Writes `count` series of `slices` images each, in ten folders.
void write_disk(const fs::path& folder, int count, int slices) {
  for (int n = 0; n < count; ++n)
    for (int k = 0; k < slices; ++k) {
      scenes::SliceSpec slice;
      slice.size = {256, 256};
      slice.number = k + 1;
      slice.position = {0, 0, 1.0 * k};
      slice.series = format_text("1.2.3.4.%d", 100 + n);
      const fs::path place = folder / format_text("S%d", n % 10);
      fs::create_directories(place);
      usual_slice(slice)
          .set(0x00200011, "IS", std::to_string(n))
          .write((place / format_text("%03d%04d", n, k)).string());
    }
}

void write_series(const fs::path& folder, int slices) {
  fs::create_directories(folder);
  for (int k = 0; k < slices; ++k) {
    scenes::SliceSpec slice;
    slice.size = {512, 512};
    slice.number = k + 1;
    slice.position = {0, 0, 0.6 * k};
    slice.spacing = {0.5, 0.5};
    usual_slice(slice).write((folder / format_text("%05d", k)).string());
  }
}

Json row(std::vector<double> ours, std::vector<double> peer) {
  const bool has_peer = !peer.empty();
  const double own = percentile_of(ours, 50), theirs = has_peer ? percentile_of(peer, 50) : 0;
  return {{"seconds", own},
          {"peer_seconds", has_peer ? Json(theirs) : Json()},
          {"peer_over_own", has_peer ? Json(theirs / own) : Json()}};
}

void print(const std::string& what, const Json& row, const std::string& peer, Outcome& outcome) {
  outcome.print(what + ": {seconds:.3f} s" +
                    (row["peer_seconds"].is_null()
                         ? ""
                         : "; " + peer + " {peer_seconds:.3f} s, {peer_over_own:.1f} times as long"),
                row);
}

}  // namespace

Status bench_dicom(const BenchArguments& arguments, Outcome& outcome) {
  const scenes::Scratch scratch;
  if (scratch.path.empty())
    return Error{.what = "no folder for temporary files",
                 .found = fs::temp_directory_path().string(),
                 .remedy = "set TMPDIR",
                 .kind = ErrorKind::missing_here};
  const int series = arguments.is_quick ? 8 : 80, slices = arguments.is_quick ? 32 : 512;
  const bool is_own = arguments.source.empty();
  const std::string disk = is_own ? scratch / "disk" : arguments.source, one = is_own ? scratch / "one" : "";
  if (is_own) write_disk(disk, series, k_images), write_series(one, slices);
  const bench::PeerSet& peers = bench::peers();
  std::vector<double> scan, scan_peer, read, read_peer;
  const int rounds = arguments.is_quick ? 1 : 5;
  std::size_t found_series = 0;
  ProgressLine progress("reading");
  for (int round = 0; round <= rounds; ++round) {  // the first round warms up, and is not counted
    if (!progress(static_cast<double>(round) / (rounds + 1))) return interrupted("the benchmark");
    const auto begin = Clock::now();
    const auto listed = data_tools::list_series(disk);
    const double scan_seconds = seconds_since(begin);
    if (!listed) return listed.error();
    found_series = listed.value().size();
    if (round > 0) scan.push_back(scan_seconds);
    if (peers.gdcm_scan) {
      int found = 0;
      const double seconds = peers.gdcm_scan(disk.c_str(), found);
      if (is_own && (found != series || found_series != static_cast<std::size_t>(series)))
        return Error{
            .what = "the disk was read incorrectly",
            .found = "trephine: " + std::to_string(found_series) + " series, GDCM: " + std::to_string(found),
            .expected = std::to_string(series),
            .remedy = "report this with the data"};
      if (round > 0) scan_peer.push_back(seconds);
    }
    if (!is_own) continue;
    const auto opened = data_tools::open_volume(one);
    if (!opened) return opened.error();
    if (round > 0) read.push_back(opened.value().read_seconds);
    if (!peers.itk_read) continue;
    long long their_sum = 0, sum = 0;
    const double seconds = peers.itk_read(one.c_str(), their_sum);
    const auto voxels = opened.value().volume.voxels.span();
    for (std::size_t i = 0; i < voxels.size(); ++i) sum += static_cast<long long>(i % 251) * voxels[i];
    if (sum != their_sum)
      return Error{.what = "ITK read other voxels from the series than this program",
                   .expected = "equal voxels",
                   .remedy = "report this with the data"};
    if (round > 0) read_peer.push_back(seconds);
  }
  outcome.json["scan"] = row(scan, scan_peer);
  outcome.json["series"] = found_series;
  print(is_own ? format_text("a disk of %d series, %d images of 256 x 256 each, found", series, k_images)
               : format_text("%zu volume%s found", found_series, found_series == 1 ? "" : "s"),
        outcome.json["scan"], "GDCM's series reader", outcome);
  if (is_own) {
    outcome.json["read"] = row(read, read_peer);
    outcome.json["slices"] = slices;
    print(format_text("%d slices of 512 x 512 read", slices), outcome.json["read"],
          "ITK's GDCM series reader", outcome);
  }
  if (!peers.gdcm_scan) outcome.print("built without GDCM: no ratio");
  return std::nullopt;
}

}  // namespace trephine::bench
