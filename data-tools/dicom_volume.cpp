#include "data-tools/dicom_volume.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <set>
#include <stdexcept>

#include "data-tools/apart.h"
#include "data-tools/dicom_pixels.h"
#include "data-tools/opening.h"
#include "data-tools/voxel_values.h"
#include "data-tools/words.h"
#include "volume/parallel.h"

namespace trephine::data_tools {

using namespace dicom_tag;
using volume::Error;
using volume::Result;
using volume::Status;
using volume::Volume;

namespace {

constexpr double k_air = -1000;

/// Slices and stack of one volume.
class Loader {
 public:
  Loader(const DicomFolder& folder, const DicomStack& stack, const OpenOptions& options, std::string where)
      : folder_(&folder), stack_(&stack), options_(&options), where_(std::move(where)) {}

  Result<OpenedVolume> load() {
    std::vector<SlicePlace> places;
    for (const DicomSlice& slice : stack_->slices) places.push_back(slice.place);
    Result<SliceStack> stacked = stack_slices(places, options_->is_resampled);
    if (!stacked) {
      Error error = stacked.error();
      error.where = where_;
      return error;
    }
    made_ = std::move(stacked).value();
    const DicomSlice& first = stack_->slices[0];
    const std::size_t count = made_.at.empty() ? stack_->slices.size() : made_.at.size();
    Result<Volume> room =
        make_room({first.columns, first.rows, static_cast<int>(count)}, made_.frame, where_);
    if (!room) return room.error();
    OpenedVolume opened;
    opened.volume = std::move(room).value();
    opened.format = "DICOM";
    if (Status error = choose_scale(opened)) return *error;
    if (Status error = fill(opened)) return *error;
    tell(opened);
    return opened;
  }

 private:
  Error broken(const DicomSlice& slice, const std::string& why) const {
    return {"an image cannot be read", where_, slice.place.name + ": " + why, "a whole image", k_copy_again};
  }
  bool goes_on(double share) const { return !options_->progress || options_->progress(share); }
  const DicomDataSet& data_of(const DicomSlice& slice) const {
    return folder_->entries[slice.entry].file.data;
  }
  std::string modality() const { return std::string(data_of(stack_->slices[0]).text(k_modality)); }

  /// Conversion of stored numbers to voxels: as Hounsfield units or whole numbers as they are; else stored
  /// numbers with a scale, or the scale that was asked for.
  Status choose_scale(OpenedVolume& opened) {
    bool is_whole = true, is_one = true, has_all = true;
    std::set<std::string> types;
    const DicomSlice& first = stack_->slices[0];
    for (const DicomSlice& slice : stack_->slices) {
      is_whole = is_whole && slice.slope == std::floor(slice.slope) &&
                 slice.intercept == std::floor(slice.intercept);
      is_one = is_one && slice.slope == first.slope && slice.intercept == first.intercept;
      has_all = has_all && slice.has_rescale;
      types.insert(slice.rescale_type);
    }
    const bool is_ct = modality() == "CT";
    const bool says_hu = types.size() == 1 && (types.begin()->empty() || *types.begin() == "HU");
    opened.modality = modality();
    opened.volume.is_hounsfield = is_ct && has_all && says_hu;
    if (is_ct && !has_all)
      opened.notices.push_back(
          "the values are not known to be Hounsfield units: slices without rescale slope and intercept");
    else if (is_ct && !says_hu)
      opened.notices.push_back(
          types.size() > 1
              ? "the values are no Hounsfield units: slices of several rescale types"
              : "the values are no Hounsfield units: the scanner gives them another rescale type");
    if (options_->scale) {
      step_ = *options_->scale;
      opened.volume.is_hounsfield = opened.volume.is_hounsfield && step_ == 1;
      opened.notices.push_back("a voxel's step is " + short_number(step_) + " of the file's units (--scale)");
    } else if (is_whole) {
      step_ = 0;
    } else if (opened.volume.is_hounsfield) {
      step_ = 1;
      opened.notices.push_back("rounded to whole Hounsfield units: at most 0.5 off");
    } else if (is_one) {
      keeps_stored_ = true;
      opened.notices.push_back("voxels are the stored numbers: the file's units are " +
                               short_number(first.slope) + " x voxel + " + short_number(first.intercept));
    } else {
      return choose_step(opened);
    }
    return std::nullopt;
  }

  /// Range of all slices, in the file's units.
  Status collect(ValueStatistics& statistics) const {
    std::vector<std::int32_t> stored;
    std::vector<double> values;
    for (const DicomSlice& slice : stack_->slices) {
      DicomPixels pixels;
      if (std::string why = DicomPixels::open(folder_->entries[slice.entry], slice, pixels); !why.empty())
        return broken(slice, why);
      if (std::string why = pixels.read(slice, stored); !why.empty()) return broken(slice, why);
      values.resize(stored.size());
      for (std::size_t k = 0; k < stored.size(); ++k) values[k] = slice.slope * stored[k] + slice.intercept;
      statistics.add(values);
    }
    return std::nullopt;
  }

  /// Every slice has a slope of its own (PET): one step for all that int16 holds, when that is finer than
  /// the noise.
  Status choose_step(OpenedVolume& opened) {
    ValueStatistics statistics;
    if (is_compressed()) {
      const auto found = SharedBytes::make(2 * sizeof(double));
      if (!found) return too_large(2 * sizeof(double), where_);
      const ApartResult ended = run_apart(
          1,
          [&](int) {
            ValueStatistics inner;
            if (collect(inner)) throw std::runtime_error("");
            const double numbers[2] = {inner.most(), inner.noise()};
            std::memcpy(found->data(), numbers, sizeof numbers);
          },
          [this](double share) { return goes_on(0.3 * share); }, 600);
      if (ended.end == ApartResult::End::stopped) return reading_interrupted(where_);
      if (ended.end == ApartResult::End::failed)
        return broken(stack_->slices[0], "its compressed pixels, or those of another slice, are damaged");
      double numbers[2];
      std::memcpy(numbers, found->data(), sizeof numbers);
      statistics = ValueStatistics(numbers[0], numbers[1]);
    } else if (Status error = collect(statistics)) {
      return error;
    }
    const ValueStep found = step_for(statistics);
    if (!found.is_finer_than_noise) return too_coarse(where_, statistics);
    step_ = found.step;
    const double noise = statistics.noise();
    opened.notices.push_back("values were scaled: the file's units are " + short_number(step_) +
                             " x voxel, at most " + short_number(0.5 * step_) + " off, noise is " +
                             short_number(noise));
    return std::nullopt;
  }

  /// Voxel of one stored number; false when int16 does not hold it.
  bool voxel_of(const DicomSlice& slice, std::int32_t stored, std::int16_t& to) const {
    double value = keeps_stored_ ? stored : slice.slope * stored + slice.intercept;
    if (step_ > 0) value = std::floor(value / step_ + 0.5);
    if (!(value >= -32768 && value <= 32767)) return false;
    to = static_cast<std::int16_t>(value);
    return true;
  }

  /// Fast path of the usual slice: 16 bits, whole numbers. False: it is another kind, or a value does not
  /// fit.
  bool read_usual_slice(const DicomPixels& pixels, const DicomSlice& slice, std::int16_t* to,
                        std::size_t& padding) const {
    const bool is_whole = slice.slope == std::floor(slice.slope) &&
                          slice.intercept == std::floor(slice.intercept) && std::abs(slice.slope) < 256 &&
                          std::abs(slice.intercept) < 1e6;
    if (step_ > 0 || keeps_stored_ || !is_whole || options_->maps_padding || !pixels.read_plain(slice, to))
      return false;
    const int slope = static_cast<int>(slice.slope), intercept = static_cast<int>(slice.intercept);
    const int spare = 32 - slice.bits_stored;
    const int low = slice.padding ? slice.padding->first : 1,
              high = slice.padding ? slice.padding->second : 0;
    const std::size_t count = static_cast<std::size_t>(slice.rows) * static_cast<std::size_t>(slice.columns);
    int least = 0, most = 0;
    std::uint32_t found = 0;
    const auto convert = [&](auto number_of) {
      for (std::size_t i = 0; i < count; ++i) {
        const int stored = number_of(static_cast<std::uint32_t>(static_cast<std::uint16_t>(to[i])));
        found += static_cast<std::uint32_t>(stored >= low) & static_cast<std::uint32_t>(stored <= high);
        const int value = slope * stored + intercept;
        least = std::min(least, value);
        most = std::max(most, value);
        to[i] = static_cast<std::int16_t>(value);
      }
    };
    if (slice.is_signed)
      convert([spare](std::uint32_t raw) { return static_cast<int>(raw << spare) >> spare; });
    else
      convert([spare](std::uint32_t raw) { return static_cast<int>(raw << spare >> spare); });
    padding = found;
    return least >= -32768 && most <= 32767;
  }

  Status read_slice(const DicomPixels& pixels, const DicomSlice& slice, std::int16_t* to,
                    std::vector<std::int32_t>& stored, std::size_t& padding) const {
    if (read_usual_slice(pixels, slice, to, padding)) return std::nullopt;
    padding = 0;
    if (std::string why = pixels.read(slice, stored); !why.empty()) return broken(slice, why);
    const bool maps = options_->maps_padding && modality() == "CT";
    for (std::size_t i = 0; i < stored.size(); ++i) {
      const bool is_padding =
          slice.padding && stored[i] >= slice.padding->first && stored[i] <= slice.padding->second;
      padding += is_padding;
      if (is_padding && maps) {
        to[i] = static_cast<std::int16_t>(k_air);
        continue;
      }
      if (voxel_of(slice, stored[i], to[i])) continue;
      const double value = slice.slope * stored[i] + slice.intercept;
      return Error{
          "a value does not fit into 16 bits", where_, short_number(value) + " in " + slice.place.name,
          "-32768 to 32767",
          "read it with a coarser step, such as --scale " + short_number(std::ceil(std::abs(value) / 32767))};
    }
    return std::nullopt;
  }

  bool is_compressed() const {
    return std::any_of(stack_->slices.begin(), stack_->slices.end(), [this](const DicomSlice& slice) {
      return folder_->entries[slice.entry].file.is_encapsulated;
    });
  }
  /// Slice k of the stack into its place, from the file of all or its own.
  Status fill_slice(std::size_t k, const DicomPixels* shared, std::int16_t* to, std::size_t area,
                    std::size_t& padding) const {
    const DicomSlice& slice = stack_->slices[static_cast<std::size_t>(made_.order[k])];
    thread_local std::vector<std::int32_t> stored;
    DicomPixels own;
    if (!shared)
      if (std::string why = DicomPixels::open(folder_->entries[slice.entry], slice, own); !why.empty())
        return broken(slice, why);
    return read_slice(shared ? *shared : own, slice, to + area * k, stored, padding);
  }

  Status fill_here(const DicomPixels* shared, std::int16_t* to, std::size_t area,
                   std::vector<std::size_t>& padding) const {
    const std::size_t all = stack_->slices.size();
    std::vector<Status> failed(all);
    constexpr std::size_t k_part = 32;
    for (std::size_t from = 0; from < all; from += k_part) {
      if (!goes_on(0.3 + 0.7 * static_cast<double>(from) / static_cast<double>(all)))
        return reading_interrupted(where_);
      const auto count = static_cast<int>(std::min(k_part, all - from));
      volume::parallel_for(count, 0, [&](int i) {
        const std::size_t k = from + static_cast<std::size_t>(i);
        failed[k] = fill_slice(k, shared, to, area, padding[k]);
      });
      for (const Status& error : failed)
        if (error) return error;
    }
    return std::nullopt;
  }

  /// Compressed pixels go through a library that damaged ones crash.
  Status fill_apart(const DicomPixels* shared, std::int16_t* to, std::size_t area,
                    std::vector<std::size_t>& padding) const {
    struct Note {
      std::size_t padding;
      char parts[4][256];  ///< of an error
    };
    const std::size_t all = stack_->slices.size(), bytes = 2 * area * all;
    const auto voxels = SharedBytes::make(bytes), notes = SharedBytes::make(sizeof(Note) * all);
    if (!voxels || !notes) return too_large(bytes, where_);
    auto* note = reinterpret_cast<Note*>(notes->data());
    const ApartResult ended = run_apart(
        static_cast<int>(all),
        [&](int i) {
          const auto k = static_cast<std::size_t>(i);
          const Status error =
              fill_slice(k, shared, reinterpret_cast<std::int16_t*>(voxels->data()), area, note[k].padding);
          if (!error) return;
          const std::string* parts[] = {&error->what, &error->found, &error->expected, &error->remedy};
          for (std::size_t p = 0; p < 4; ++p) parts[p]->copy(note[k].parts[p], sizeof note[k].parts[p] - 1);
        },
        [this](double share) { return goes_on(0.3 + 0.7 * share); });
    if (ended.end == ApartResult::End::stopped) return reading_interrupted(where_);
    if (ended.end == ApartResult::End::failed)
      return broken(stack_->slices[static_cast<std::size_t>(
                        made_.order[static_cast<std::size_t>(std::max(ended.at, 0))])],
                    ended.found);
    for (std::size_t k = 0; k < all; ++k) {
      if (const auto& parts = note[k].parts; parts[0][0] != '\0')
        return Error{parts[0], where_, parts[1], parts[2], parts[3]};
      padding[k] = note[k].padding;
    }
    std::memcpy(to, voxels->data(), bytes);
    return std::nullopt;
  }

  Status fill(OpenedVolume& opened) {
    Volume& v = opened.volume;
    const std::size_t area = static_cast<std::size_t>(v.size.x) * static_cast<std::size_t>(v.size.y);
    const std::vector<DicomSlice>& slices = stack_->slices;
    // Inputs in the order of the stack; where slices are made they are kept apart first.
    volume::Buffer<std::int16_t> inputs;
    if (!made_.at.empty()) inputs = volume::Buffer<std::int16_t>(area * slices.size());
    std::int16_t* to = made_.at.empty() ? v.voxels.data() : inputs.data();
    std::vector<std::size_t> padding(slices.size(), 0);
    // One file of many frames is opened once; many files are read side by side.
    const bool is_one_file = slices.size() > 1 && slices.front().entry == slices.back().entry;
    DicomPixels shared;
    if (is_one_file)
      if (std::string why = DicomPixels::open(folder_->entries[slices[0].entry], slices[0], shared);
          !why.empty())
        return broken(slices[0], why);
    if (is_compressed()) {
      if (Status error = fill_apart(is_one_file ? &shared : nullptr, to, area, padding)) return error;
    } else if (Status error = fill_here(is_one_file ? &shared : nullptr, to, area, padding)) {
      return error;
    }
    for (std::size_t k = 0; k < made_.at.size(); ++k) {
      const auto below = static_cast<std::size_t>(made_.at[k]);
      const double share = made_.at[k] - static_cast<double>(below);
      const std::int16_t *a = inputs.data() + area * below, *b = share > 0 ? a + area : a;
      std::int16_t* out = v.voxels.data() + area * k;
      for (std::size_t i = 0; i < area; ++i)
        out[i] = static_cast<std::int16_t>(std::floor((1 - share) * a[i] + share * b[i] + 0.5));
      made_slices_ += share > 0;
    }
    for (const std::size_t n : padding) padding_ += n;
    return std::nullopt;
  }

  void tell(OpenedVolume& opened) const {
    const DicomSlice& first = stack_->slices[0];
    if (made_.tilt_degrees >= 0.01)
      opened.notices.push_back("the gantry was tilted by " + short_number(made_.tilt_degrees) +
                               " degrees: slices keep their places (a sheared volume)");
    if (!made_.at.empty())
      opened.notices.push_back(counted(made_slices_, "slice") + " of " + std::to_string(made_.at.size()) +
                               " were interpolated (--resample)");
    if (opened.volume.size.z == 1)
      opened.notices.push_back(first.place.thickness > 0
                                   ? "one slice only: its thickness of " +
                                         short_number(made_.frame.spacing().z) +
                                         " mm stands for the distance of slices"
                                   : "one slice only, which does not state its thickness: 1 mm was assumed");
    std::set<std::size_t> padded;
    for (const DicomSlice& slice : stack_->slices) {
      const DicomEntry& entry = folder_->entries[slice.entry];
      if (!entry.file.is_encapsulated && entry.file.pixel_bytes > expected_pixel_bytes(entry, slice) + 1)
        padded.insert(slice.entry);
    }
    if (!padded.empty())
      opened.notices.push_back("excess bytes behind the pixels of " + counted(padded.size(), "file") +
                               " were ignored");
    if (padding_ > 0 && opened.volume.is_hounsfield) {
      std::int16_t value = 0;
      const bool is_held = voxel_of(first, first.padding ? first.padding->first : 0, value);
      if (options_->maps_padding)
        opened.notices.push_back(counted(padding_, "voxel") + " of padding became air (-1000)");
      else if (is_held && value > -500)
        opened.notices.push_back(counted(padding_, "voxel") + " of padding have the value " +
                                 std::to_string(value) +
                                 ", which is not air: --padding-to-air makes it that");
    }
    const DicomDataSet& data = data_of(first);
    const std::pair<const char*, DicomTag> allowed[] = {{"modality", k_modality},
                                                        {"manufacturer", k_manufacturer},
                                                        {"model", k_model},
                                                        {"kernel", k_kernel},
                                                        {"kvp", k_kvp},
                                                        {"slice thickness", k_slice_thickness},
                                                        {"body part", k_body_part}};
    for (const auto& [name, tag] : allowed)
      if (const std::string_view text = data.text(tag); !text.empty()) opened.facts.emplace_back(name, text);
  }

  const DicomFolder* folder_;
  const DicomStack* stack_;
  const OpenOptions* options_;
  std::string where_;
  SliceStack made_;
  double step_ = 0;  ///< 0: values as they are
  bool keeps_stored_ = false;
  std::size_t padding_ = 0, made_slices_ = 0;
};

}  // namespace

Result<OpenedVolume> load_dicom_stack(const DicomFolder& folder, const DicomStack& stack,
                                      const OpenOptions& options, const std::string& where) {
  return Loader(folder, stack, options, where).load();
}

}  // namespace trephine::data_tools
