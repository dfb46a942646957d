#include "data-tools/dicom/dicom_repeats.h"

#include <algorithm>
#include <charconv>
#include <glm/geometric.hpp>
#include <iterator>
#include <map>
#include <numeric>
#include <optional>
#include <set>

#include "data-tools/files/words.h"
#include "volume/base/mix_hash.h"
#include "volume/base/parallel.h"

namespace trephine::data_tools {

namespace {

constexpr double k_same_direction = 1e-3;  // difference of unit vectors; stack_slices() is stricter
constexpr double k_same_mm = 1e-3;

bool have_same_position(const DicomSlice& a, const DicomSlice& b) {
  return glm::length(a.plane.position - b.plane.position) < k_same_mm;
}

/// Returns a hash of the bytes of a file's pixels; empty if they cannot be read.
std::optional<std::uint64_t> pixel_hash(const DicomEntry& entry) {
  const auto opened = entry.file.source ? nullptr : ByteSource::open(entry.path);
  const ByteSource* source = opened ? opened.get() : entry.file.source.get();
  if (!source) return std::nullopt;
  MixHash hash;
  std::vector<std::uint64_t> part(1 << 15);
  for (std::uint64_t offset = 0; offset < entry.file.pixel_bytes;) {
    const std::uint64_t count = std::min<std::uint64_t>(8 * part.size(), entry.file.pixel_bytes - offset);
    std::fill(part.begin(), part.end(), 0);
    if (!source->read(entry.file.pixel_offset + offset, part.data(), count)) return std::nullopt;
    for (std::size_t i = 0; i < (count + 7) / 8; ++i) hash.add(part[i]);
    offset += count;
  }
  return hash.value();
}

/// Returns true if two slices of different files have equal frame numbers and rescales, and the pixels of
/// their files have the same transfer syntax and equal bytes.
bool are_same_pixels(const DicomFolder& folder, const DicomSlice& a, const DicomSlice& b) {
  const DicomFile &f = folder.entries[a.entry].file, &g = folder.entries[b.entry].file;
  const auto reopen = [](const DicomEntry& entry) {
    return entry.file.source ? nullptr : ByteSource::open(entry.path);
  };
  const auto reopened_a = reopen(folder.entries[a.entry]), reopened_b = reopen(folder.entries[b.entry]);
  const ByteSource *source_a = reopened_a ? reopened_a.get() : f.source.get(),
                   *source_b = reopened_b ? reopened_b.get() : g.source.get();
  if (!source_a || !source_b) return false;
  if (a.entry == b.entry || a.frame != b.frame || f.pixel_bytes != g.pixel_bytes ||
      f.transfer_syntax != g.transfer_syntax || a.slope != b.slope || a.intercept != b.intercept)
    return false;
  std::string x(1 << 20, '\0'), y = x;
  for (std::uint64_t offset = 0; offset < f.pixel_bytes;) {
    const auto part = static_cast<std::size_t>(std::min<std::uint64_t>(x.size(), f.pixel_bytes - offset));
    if (!source_a->read(f.pixel_offset + offset, x.data(), part) ||
        !source_b->read(g.pixel_offset + offset, y.data(), part) || x.compare(0, part, y, 0, part) != 0)
      return false;
    offset += part;
  }
  return true;
}

/// Returns the indices of the slices, sorted along their normal.
std::vector<std::size_t> sort_by_height(const std::vector<DicomSlice>& slices) {
  const glm::dvec3 normal = glm::cross(slices[0].plane.row_axis, slices[0].plane.column_axis);
  std::vector<std::size_t> order(slices.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return glm::dot(slices[a].plane.position, normal) < glm::dot(slices[b].plane.position, normal);
  });
  return order;
}

/// Returns the number of different positions.
std::size_t count_positions(const std::vector<DicomSlice>& slices) {
  const std::vector<std::size_t> order = sort_by_height(slices);
  std::size_t count = 1;
  for (std::size_t i = 1; i < order.size(); ++i)
    count += !have_same_position(slices[order[i - 1]], slices[order[i]]);
  return count;
}
/// Returns the largest number of slices at one position.
std::size_t max_per_position(const std::vector<DicomSlice>& slices) {
  const std::vector<std::size_t> order = sort_by_height(slices);
  std::size_t max_count = 1, count = 1;
  for (std::size_t i = 1; i < order.size(); ++i) {
    count = have_same_position(slices[order[i - 1]], slices[order[i]]) ? count + 1 : 1;
    max_count = std::max(max_count, count);
  }
  return max_count;
}
}  // namespace

bool have_same_grid(const DicomSlice& a, const DicomSlice& b) {
  const auto close = [](double x, double y) { return std::abs(x - y) <= 1e-3 * std::abs(x); };
  return a.rows == b.rows && a.columns == b.columns &&
         glm::length(a.plane.row_axis - b.plane.row_axis) < k_same_direction &&
         glm::length(a.plane.column_axis - b.plane.column_axis) < k_same_direction &&
         close(a.plane.row_spacing, b.plane.row_spacing) &&
         close(a.plane.column_spacing, b.plane.column_spacing);
}

bool has_repeated_positions(const std::vector<DicomSlice>& slices) {
  return count_positions(slices) < slices.size();
}

std::vector<std::string> drop_copies(const DicomFolder& folder, std::vector<DicomSlice>& slices) {
  std::vector<std::string> removed;
  if (!has_repeated_positions(slices)) return removed;
  const std::vector<std::size_t> order = sort_by_height(slices);
  // Hash the files of slices whose marks equal those of another slice at the same position.
  std::vector<char> needs_hash(slices.size(), 0), is_copy(slices.size(), 0);
  for (std::size_t i = 0; i < order.size(); ++i)
    for (std::size_t k = i + 1; k < order.size() && have_same_position(slices[order[i]], slices[order[k]]);
         ++k)
      if (slices[order[i]].marks == slices[order[k]].marks) needs_hash[order[i]] = needs_hash[order[k]] = 1;
  std::vector<std::optional<std::uint64_t>> hashes(slices.size());
  parallel_for(static_cast<int>(slices.size()), 0, [&](int i) {
    const auto n = static_cast<std::size_t>(i);
    if (needs_hash[n]) hashes[n] = pixel_hash(folder.entries[slices[n].entry]);
  });
  for (std::size_t i = 0; i < order.size(); ++i)
    for (std::size_t k = i + 1; k < order.size() && have_same_position(slices[order[i]], slices[order[k]]);
         ++k) {
      if (is_copy[order[i]] || is_copy[order[k]]) continue;
      const DicomSlice &a = slices[order[i]], &b = slices[order[k]];
      // Equal pixels with different marks, such as another phase, are not copies.
      if (a.marks != b.marks || hashes[order[i]] != hashes[order[k]] || !are_same_pixels(folder, a, b))
        continue;
      is_copy[order[k]] = 1;
      removed.push_back(b.plane.name);
    }
  std::vector<DicomSlice> remaining;
  for (std::size_t i = 0; i < slices.size(); ++i)
    if (!is_copy[i]) remaining.push_back(std::move(slices[i]));
  slices = std::move(remaining);
  return removed;
}

namespace {

/// Returns the value of a mark that is a number; nullopt for other texts.
std::optional<double> number_in(const std::string& text) {
  double number = 0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, number);
  return error == std::errc() && stop == end ? std::optional(number) : std::nullopt;
}

/// Returns true if mark `a` precedes mark `b`: numbers first, by value; then texts.
bool is_before(const std::string& a, const std::string& b) {
  const std::optional<double> x = number_in(a), y = number_in(b);
  if (x && y && *x != *y) return *x < *y;
  return x.has_value() != y.has_value() ? x.has_value() : a < b;
}

}  // namespace

void split_repeats(DicomStack stack, std::size_t mark, std::vector<DicomStack>& stacks) {
  if (!has_repeated_positions(stack.slices)) return stacks.push_back(std::move(stack));
  const std::size_t marks = stack.slices[0].marks.size(), position_count = count_positions(stack.slices),
                    most_per_position = max_per_position(stack.slices);
  for (; mark < marks; ++mark) {
    std::map<std::string, DicomStack> parts;
    std::vector<std::string> values;
    for (DicomSlice& slice : stack.slices) {
      const auto& [name, value] = slice.marks[mark];
      DicomStack& part = parts[value];
      if (part.slices.empty()) {
        values.push_back(value);
        part.mark =
            stack.mark + (stack.mark.empty() ? "" : ", ") + name + " " + (value.empty() ? "?" : value);
        part.is_localizer = stack.is_localizer;
      }
      part.slices.push_back(slice);
    }
    // A mark distinguishes slices in two cases. Either one part has a slice at every position; or no part has
    // two slices at one position, and the number of parts is at most that of the slices at one position. In
    // the second case every part may lack slices.
    const bool has_whole = std::any_of(parts.begin(), parts.end(), [&](const auto& part) {
      return count_positions(part.second.slices) == position_count;
    });
    const bool are_without_repeats =
        parts.size() <= most_per_position && std::none_of(parts.begin(), parts.end(), [](const auto& part) {
          return has_repeated_positions(part.second.slices);
        });
    if (parts.size() < 2 || (!has_whole && !are_without_repeats)) continue;
    std::stable_sort(values.begin(), values.end(), is_before);
    for (const std::string& value : values) split_repeats(std::move(parts[value]), mark + 1, stacks);
    return;
  }
  // No mark distinguishes the slices. The order of the instance numbers does if these numbers differ and each
  // position has the same number of slices.
  std::vector<std::size_t> order = sort_by_height(stack.slices);
  std::vector<std::vector<std::size_t>> positions;
  for (const std::size_t i : order) {
    if (positions.empty() || !have_same_position(stack.slices[positions.back()[0]], stack.slices[i]))
      positions.emplace_back();
    positions.back().push_back(i);
  }
  const std::size_t volumes = positions[0].size();
  std::set<long> numbers;
  for (const DicomSlice& slice : stack.slices) numbers.insert(slice.number);
  const bool is_regular =
      numbers.size() == stack.slices.size() &&
      std::all_of(positions.begin(), positions.end(), [&](const auto& p) { return p.size() == volumes; });
  if (!is_regular) return stacks.push_back(std::move(stack));  // load_dicom_stack() returns the error
  for (auto& slices_there : positions)
    std::sort(slices_there.begin(), slices_there.end(),
              [&](std::size_t a, std::size_t b) { return stack.slices[a].number < stack.slices[b].number; });
  for (std::size_t v = 0; v < volumes; ++v) {
    DicomStack part;
    part.mark = stack.mark + (stack.mark.empty() ? "" : ", ") + "repetition " + std::to_string(v + 1);
    part.is_localizer = stack.is_localizer;
    for (const auto& slices_there : positions) part.slices.push_back(stack.slices[slices_there[v]]);
    stacks.push_back(std::move(part));
  }
}

void join_lone_slices(DicomFolder& folder) {
  std::map<std::string, std::vector<std::size_t>> groups;
  for (std::size_t s = 0; s < folder.series.size(); ++s) {
    const DicomSeries& series = folder.series[s];
    if (series.stacks.size() != 1 || series.stacks[0].slices.size() != 1 || series.stacks[0].is_localizer)
      continue;
    std::string key;
    for (const std::string* text : {&series.modality, &series.number, &series.description, &series.kernel})
      key.append(*text).append("|");
    groups[key].push_back(s);
  }
  constexpr std::size_t k_min = 3;
  std::vector<char> is_joined(folder.series.size(), 0);
  for (const auto& [key, members] : groups) {
    if (members.size() < k_min) continue;
    const DicomSlice& first = folder.series[members[0]].stacks[0].slices[0];
    std::vector<DicomSlice> slices;
    std::vector<SlicePosition> positions;
    for (const std::size_t s : members) {
      const DicomSlice& slice = folder.series[s].stacks[0].slices[0];
      if (!have_same_grid(first, slice)) break;
      slices.push_back(slice);
      positions.push_back(slice.plane);
    }
    if (slices.size() < members.size() || !stack_slices(positions)) continue;
    for (const std::size_t s : members) is_joined[s] = s != members[0];
    folder.series[members[0]].stacks[0].slices = std::move(slices);
    folder.notices.push_back(
        std::to_string(members.size()) +
        " series of one slice each were joined, since they form one regular stack: each slice has its own "
        "series UID");
  }
  std::vector<DicomSeries> remaining;
  for (std::size_t s = 0; s < folder.series.size(); ++s)
    if (!is_joined[s]) remaining.push_back(std::move(folder.series[s]));
  folder.series = std::move(remaining);
}

}  // namespace trephine::data_tools
