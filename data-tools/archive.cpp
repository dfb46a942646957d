#include "data-tools/archive.h"

#include <algorithm>
#include <archive.h>
#include <archive_entry.h>
#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <zlib.h>

#include "data-tools/atomic_file.h"
#include "data-tools/names_met.h"
#include "data-tools/opening.h"
#include "volume/volume.h"

namespace trephine::data_tools {

using volume::Error;
using volume::Result;

namespace {

constexpr std::size_t k_most_members = 200'000;
// A little that unpacks to very much is made to fill a machine.
constexpr std::uint64_t k_most_times = 200, k_always_allowed = 256u << 20;

/// libarchive does not look at the checksum of gzip.
bool is_whole_gzip(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  unsigned char head[2] = {};
  in.read(reinterpret_cast<char*>(head), 2);
  if (head[0] != 0x1f || head[1] != 0x8b) return true;
  gzFile file = gzopen(path.c_str(), "rb");
  if (file == nullptr) return false;
  std::vector<char> part(1 << 20);
  int got = 0;
  while ((got = gzread(file, part.data(), static_cast<unsigned>(part.size()))) > 0) {}
  return (gzclose_r(file) == Z_OK) && got == 0;
}

/// A tar ends with zeros; one that was cut between two files looks whole without them.
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
  const auto begins = [&](std::initializer_list<int> bytes) {
    return in.gcount() >= static_cast<std::streamsize>(bytes.size()) &&
           std::equal(bytes.begin(), bytes.end(), head.begin(),
                      [](int a, unsigned char b) { return a == b; });
  };
  return begins({'P', 'K', 3, 4}) || begins({0x1f, 0x8b}) || begins({0xfd, '7', 'z', 'X', 'Z'}) ||
         begins({'B', 'Z', 'h'}) || begins({'7', 'z', 0xbc, 0xaf}) ||
         (in.gcount() == 262 && std::memcmp(head.data() + 257, "ustar", 5) == 0);
}

Result<std::vector<ArchiveMember>> read_archive(const std::string& path, const Progress& progress) {
  const std::string where = file_name(path);
  const Archive reader(archive_read_new(), archive_read_free);
  archive_read_support_filter_all(reader.get());
  for (const auto support : {archive_read_support_format_zip, archive_read_support_format_tar,
                             archive_read_support_format_7zip, archive_read_support_format_raw})
    support(reader.get());
  const auto damaged = [&] {
    Error error{"the archive cannot be unpacked", where, "damaged contents, or another kind of file",
                "a whole .zip, .tar or .gz", "copy it again, or unpack it yourself and point at the folder"};
    const int format = archive_format(reader.get()) & ARCHIVE_FORMAT_BASE_MASK;  // asked of others it crashes
    if ((format == ARCHIVE_FORMAT_ZIP || format == ARCHIVE_FORMAT_7ZIP) &&
        archive_read_has_encrypted_entries(reader.get()) > 0)
      error.found = "it is protected by a password",
      error.remedy = "unpack it yourself and point at the folder";
    return error;
  };
  if (!is_whole_gzip(path) || !is_whole_tar(path))
    return Error{"the archive cannot be unpacked", where, "its end is missing, or its checksum is wrong",
                 "a whole .zip, .tar or .gz", "copy it again, or unpack it yourself and point at the folder"};
  if (archive_read_open_filename(reader.get(), path.c_str(), 1 << 20) != ARCHIVE_OK) return damaged();
  std::error_code ignored;
  const std::uint64_t packed = std::filesystem::file_size(path, ignored);
  const std::uint64_t most = std::min<std::uint64_t>(volume::available_memory_bytes() / 2,
                                                     std::max(k_always_allowed, k_most_times * packed));
  std::vector<ArchiveMember> members;
  std::uint64_t total = 0;
  for (;;) {
    archive_entry* entry = nullptr;
    const int state = archive_read_next_header(reader.get(), &entry);
    if (state == ARCHIVE_EOF) break;
    if (state != ARCHIVE_OK && state != ARCHIVE_WARN) return damaged();
    if (archive_entry_filetype(entry) != AE_IFREG) continue;
    const char* name = archive_entry_pathname(entry);
    ArchiveMember member{name ? name : "", nullptr};
    meet_name(member.name);
    // A compressed file alone is named as it is, without its last extension.
    if (archive_format(reader.get()) == ARCHIVE_FORMAT_RAW)
      member.name = std::filesystem::path(where).stem().string();
    std::string bytes;
    for (;;) {
      const void* part = nullptr;
      std::size_t size = 0;
      la_int64_t offset = 0;
      const int read = archive_read_data_block(reader.get(), &part, &size, &offset);
      if (read == ARCHIVE_EOF) break;
      if (read != ARCHIVE_OK) return damaged();  // a wrong checksum is a warning there
      total += size;
      if (total > most || offset < 0 || static_cast<std::uint64_t>(offset) > most)
        return Error{"the archive unpacks to more than there is room for", where,
                     "more than " + std::to_string(most >> 20) + " MiB", "what fits into memory twice",
                     "unpack it yourself and point at the folder"};
      bytes.resize(static_cast<std::size_t>(offset));
      bytes.append(static_cast<const char*>(part), size);
    }
    member.bytes = std::make_shared<const std::string>(std::move(bytes));
    members.push_back(std::move(member));
    if (members.size() > k_most_members)
      return Error{"the archive holds too many files", where, "more than " + std::to_string(k_most_members),
                   "", "unpack it yourself and point at the folder of one patient"};
    if (progress && !progress(0.2 * static_cast<double>(archive_filter_bytes(reader.get(), -1)) /
                              static_cast<double>(std::max<std::uint64_t>(packed, 1))))
      return reading_interrupted(where);
  }
  return members;
}

}  // namespace trephine::data_tools
