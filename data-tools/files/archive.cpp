#include "data-tools/files/archive.h"

#include <algorithm>
#include <archive.h>
#include <archive_entry.h>
#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <zlib.h>

#include "data-tools/files/atomic_file.h"
#include "data-tools/files/sensitive_names.h"
#include "data-tools/formats/reader_support.h"
#include "volume/scan/volume.h"

namespace trephine::data_tools {

namespace {

constexpr std::size_t k_max_members = 200'000;
// Limit against archive bombs: largest ratio of unpacked to packed size, and bytes that are always allowed.
constexpr std::uint64_t k_largest_ratio = 200, k_always_allowed_bytes = 256u << 20;

/// Returns false for a gzip file with a wrong checksum or without its end. libarchive checks neither.
bool is_whole_gzip(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  unsigned char head[2] = {};
  in.read(reinterpret_cast<char*>(head), 2);
  if (head[0] != 0x1f || head[1] != 0x8b) return true;
  gzFile file = gzopen(path.c_str(), "rb");
  if (file == nullptr) return false;
  std::vector<char> part(1 << 20);
  int read_bytes = 0;
  while ((read_bytes = gzread(file, part.data(), static_cast<unsigned>(part.size()))) > 0) {}
  return (gzclose_r(file) == Z_OK) && read_bytes == 0;
}

/// Returns false for a tar file that does not end with 1024 zero bytes, for example because it was truncated
/// between two members.
bool is_whole_tar(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  char magic[5] = {};
  in.seekg(257);
  in.read(magic, 5);
  if (std::memcmp(magic, "ustar", 5) != 0) return true;
  std::array<char, 1024> end{};
  in.seekg(-1024, std::ios::end);
  in.read(end.data(), end.size());
  return in && std::all_of(end.begin(), end.end(), [](char c) { return c == 0; });
}

using Archive = std::unique_ptr<archive, int (*)(archive*)>;

}  // namespace

bool is_archive(const std::string& path) {
  std::array<unsigned char, 262> head{};
  std::ifstream in(path, std::ios::binary);
  in.read(reinterpret_cast<char*>(head.data()), head.size());
  const auto starts_with = [&](std::initializer_list<int> bytes) {
    return in.gcount() >= static_cast<std::streamsize>(bytes.size()) &&
           std::equal(bytes.begin(), bytes.end(), head.begin(),
                      [](int a, unsigned char b) { return a == b; });
  };
  return starts_with({'P', 'K', 3, 4}) || starts_with({0x1f, 0x8b}) ||
         starts_with({0xfd, '7', 'z', 'X', 'Z'}) || starts_with({'B', 'Z', 'h'}) ||
         starts_with({'7', 'z', 0xbc, 0xaf}) ||
         (in.gcount() == 262 && std::memcmp(head.data() + 257, "ustar", 5) == 0);
}

Result<std::vector<ArchiveMember>> read_archive(const std::string& path, const Progress& progress) {
  const std::string archive_name = file_name(path);
  const Archive reader(archive_read_new(), archive_read_free);
  archive_read_support_filter_all(reader.get());
  for (const auto support : {archive_read_support_format_zip, archive_read_support_format_tar,
                             archive_read_support_format_7zip, archive_read_support_format_raw})
    support(reader.get());
  const auto damage_error = [&] {
    Error error{"the archive cannot be unpacked", archive_name, "damaged contents, or another kind of file",
                "a complete .zip, .tar or .gz", "copy it again, or unpack it and pass the folder"};
    // archive_read_has_encrypted_entries() crashes for formats other than .zip and .7z.
    const int format = archive_format(reader.get()) & ARCHIVE_FORMAT_BASE_MASK;
    if ((format == ARCHIVE_FORMAT_ZIP || format == ARCHIVE_FORMAT_7ZIP) &&
        archive_read_has_encrypted_entries(reader.get()) > 0)
      error.found = "it is protected by a password", error.remedy = "unpack it and pass the folder";
    return error;
  };
  if (!is_whole_gzip(path) || !is_whole_tar(path))
    return Error{.what = "the archive cannot be unpacked",
                 .where = archive_name,
                 .found = "its end is missing, or its checksum is wrong",
                 .expected = "a complete .zip, .tar or .gz",
                 .remedy = "copy it again, or unpack it and pass the folder"};
  if (archive_read_open_filename(reader.get(), path.c_str(), 1 << 20) != ARCHIVE_OK) return damage_error();
  std::error_code ignored;
  const std::uint64_t packed_bytes = std::filesystem::file_size(path, ignored);
  const std::uint64_t limit = std::min<std::uint64_t>(
      volume::available_memory_bytes() / 2, std::max(k_always_allowed_bytes, k_largest_ratio * packed_bytes));
  std::vector<ArchiveMember> members;
  std::uint64_t total = 0;
  for (;;) {
    archive_entry* entry = nullptr;
    const int state = archive_read_next_header(reader.get(), &entry);
    if (state == ARCHIVE_EOF) break;
    if (state != ARCHIVE_OK && state != ARCHIVE_WARN) return damage_error();
    if (archive_entry_filetype(entry) != AE_IFREG) continue;
    const char* name = archive_entry_pathname(entry);
    ArchiveMember member{name ? name : "", nullptr};
    record_sensitive_name(member.name);
    // A single compressed file gets the name of the archive without the last extension.
    if (archive_format(reader.get()) == ARCHIVE_FORMAT_RAW)
      member.name = std::filesystem::path(archive_name).stem().string();
    std::string bytes;
    for (;;) {
      const void* part = nullptr;
      std::size_t size = 0;
      la_int64_t offset = 0;
      const int read = archive_read_data_block(reader.get(), &part, &size, &offset);
      if (read == ARCHIVE_EOF) break;
      if (read != ARCHIVE_OK) return damage_error();  // a wrong checksum is ARCHIVE_WARN
      total += size;
      if (total > limit || offset < 0 || static_cast<std::uint64_t>(offset) > limit)
        return Error{.what = "the unpacked archive is too large",
                     .where = archive_name,
                     .found = "more than " + std::to_string(limit >> 20) + " MiB",
                     .expected =
                         "at most half of the free memory, and at most the larger of 256 MiB and 200 times "
                         "the packed size",
                     .remedy = "unpack it and pass the folder"};
      bytes.resize(static_cast<std::size_t>(offset));
      bytes.append(static_cast<const char*>(part), size);
    }
    member.bytes = std::make_shared<const std::string>(std::move(bytes));
    members.push_back(std::move(member));
    if (members.size() > k_max_members)
      return Error{.what = "the archive contains too many files",
                   .where = archive_name,
                   .found = "more than " + std::to_string(k_max_members),
                   .remedy = "unpack it and pass the folder of one patient"};
    if (progress && !progress(0.2 * static_cast<double>(archive_filter_bytes(reader.get(), -1)) /
                              static_cast<double>(std::max<std::uint64_t>(packed_bytes, 1))))
      return reading_interrupted(archive_name);
  }
  return members;
}

}  // namespace trephine::data_tools
