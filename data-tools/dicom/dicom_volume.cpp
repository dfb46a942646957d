#include "data-tools/dicom/dicom_volume.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <set>
#include <stdexcept>

#include "data-tools/dicom/dicom_pixels.h"
#include "data-tools/files/subprocess.h"
#include "data-tools/files/words.h"
#include "data-tools/formats/reader_support.h"
#include "data-tools/formats/voxel_values.h"
#include "volume/base/parallel.h"
#include "volume/base/text.h"

namespace trephine::data_tools {

using namespace dicom_tag;
using volume::Volume;

namespace {

constexpr double k_air = -1000;

/// Reads the slices of one stack into a volume.
class Loader {
 public:
  Loader(const DicomFolder& folder, const DicomStack& stack, const OpenOptions& options, std::string where)
      : folder_(&folder), stack_(&stack), options_(&options), where_(std::move(where)) {}

  Result<OpenedVolume> load() {
    std::vector<SlicePosition> positions;
    for (const DicomSlice& slice : stack_->slices) positions.push_back(slice.plane);
    Result<SliceStack> stack_result = stack_slices(positions, options_->is_resampled);
    if (!stack_result) {
      Error error = stack_result.error();
      error.where = where_;
      return error;
    }
    geometry_ = std::move(stack_result).value();
    const DicomSlice& first = stack_->slices[0];
    const std::size_t count = geometry_.at.empty() ? stack_->slices.size() : geometry_.at.size();
    Result<Volume> allocated =
        allocate_volume({first.columns, first.rows, static_cast<int>(count)}, geometry_.frame, where_);
    if (!allocated) return allocated.error();
    OpenedVolume opened;
    opened.volume = std::move(allocated).value();
    opened.format = "DICOM";
    if (Status error = choose_scale(opened)) return *error;
    if (Status error = fill(opened)) return *error;
    add_notices(opened);
    return opened;
  }

 private:
  Error slice_error(const DicomSlice& slice, const std::string& reason) const {
    return Error{.what = "an image cannot be read",
                 .where = where_,
                 .found = slice.plane.name + ": " + reason,
                 .expected = "a complete image",
                 .remedy = k_copy_again};
  }
  bool report_progress(double share) const { return !options_->progress || options_->progress(share); }
  const DicomDataSet& data_of(const DicomSlice& slice) const {
    return folder_->entries[slice.entry].file.data;
  }
  std::string modality() const { return std::string(data_of(stack_->slices[0]).text(k_modality)); }

  /// Selects the conversion of stored numbers to voxels. A requested scale has precedence. Otherwise values
  /// are unchanged if slope and intercept are whole numbers, and are rounded if they are Hounsfield units.
  /// Other values are kept as stored numbers if all slices have the same slope and intercept; else see
  /// choose_step().
  Status choose_scale(OpenedVolume& opened) {
    bool is_whole = true, is_uniform = true, has_all_rescales = true;
    std::set<std::string> types;
    const DicomSlice& first = stack_->slices[0];
    for (const DicomSlice& slice : stack_->slices) {
      is_whole = is_whole && slice.slope == std::floor(slice.slope) &&
                 slice.intercept == std::floor(slice.intercept);
      is_uniform = is_uniform && slice.slope == first.slope && slice.intercept == first.intercept;
      has_all_rescales = has_all_rescales && slice.has_rescale;
      types.insert(slice.rescale_type);
    }
    // Some slices with and some without a rescale would mix two scales.
    if (const auto lacking = std::find_if(stack_->slices.begin(), stack_->slices.end(),
                                          [](const DicomSlice& slice) { return !slice.has_rescale; });
        lacking != stack_->slices.end() &&
        std::any_of(stack_->slices.begin(), stack_->slices.end(),
                    [](const DicomSlice& slice) { return slice.has_rescale; }))
      return Error{.what = "some slices lack rescale slope and intercept",
                   .where = where_,
                   .found = lacking->plane.name + " lacks them, other slices have them",
                   .expected = "a rescale in all slices or in none",
                   .remedy = "export the series again, or remove the files without it"};
    const bool is_ct = modality() == "CT";
    const bool states_hounsfield = types.size() == 1 && (types.begin()->empty() || *types.begin() == "HU");
    opened.modality = modality();
    opened.volume.is_hounsfield = is_ct && has_all_rescales && states_hounsfield;
    if (is_ct && !has_all_rescales)
      opened.notices.push_back(
          "the values are not known to be Hounsfield units: the slices have no rescale slope and intercept");
    else if (is_ct && !states_hounsfield)
      opened.notices.push_back(
          types.size() > 1 ? "the values are not Hounsfield units: slices have several rescale types"
                           : "the values are not Hounsfield units: the scanner states another rescale type");
    if (options_->scale) {
      step_ = *options_->scale;
      opened.volume.is_hounsfield = opened.volume.is_hounsfield && step_ == 1;
      opened.notices.push_back("one voxel unit is " + rounded_text(step_) +
                               " of the file's units (option scale)");
    } else if (is_whole) {
      step_ = 0;
    } else if (opened.volume.is_hounsfield) {
      step_ = 1;
      opened.notices.push_back("rounded to whole Hounsfield units: rounding error at most 0.5");
    } else if (is_uniform) {
      keeps_stored_ = true;
      opened.notices.push_back("voxels are the stored numbers: the file's units are " +
                               rounded_text(first.slope) + " x voxel + " + rounded_text(first.intercept));
    } else {
      return choose_step(opened);
    }
    return std::nullopt;
  }

  /// Collects the range and noise of all slices, in the file's units.
  Status collect(ValueStatistics& statistics) const {
    std::vector<std::int32_t> stored;
    std::vector<double> values;
    for (const DicomSlice& slice : stack_->slices) {
      DicomPixels pixels;
      if (std::string reason = DicomPixels::open(folder_->entries[slice.entry], slice, pixels);
          !reason.empty())
        return slice_error(slice, reason);
      if (std::string reason = pixels.read(slice, stored); !reason.empty()) return slice_error(slice, reason);
      values.resize(stored.size());
      for (std::size_t k = 0; k < stored.size(); ++k) values[k] = slice.slope * stored[k] + slice.intercept;
      statistics.add(values);
    }
    return std::nullopt;
  }

  /// Selects one scale for slices with different slopes (PET): the step with which all values fit into int16.
  /// Error if this step is not finer than the noise.
  Status choose_step(OpenedVolume& opened) {
    ValueStatistics statistics;
    if (is_compressed()) {
      const auto shared = SharedBytes::make(2 * sizeof(double));
      if (!shared) return too_large(2 * sizeof(double), where_);
      const SubprocessResult result = run_in_subprocess(
          1,
          [&](int) {
            ValueStatistics child_statistics;
            if (collect(child_statistics)) throw std::runtime_error("");
            const double numbers[2] = {child_statistics.max_magnitude(), child_statistics.noise()};
            std::memcpy(shared->data(), numbers, sizeof numbers);
          },
          [this](double share) { return report_progress(0.3 * share); }, 600);
      if (result.end == SubprocessResult::End::stopped) return reading_interrupted(where_);
      if (result.end == SubprocessResult::End::failed)
        return slice_error(stack_->slices[0],
                           "its compressed pixels, or those of another slice, are damaged");
      double numbers[2];
      std::memcpy(numbers, shared->data(), sizeof numbers);
      statistics = ValueStatistics(numbers[0], numbers[1]);
    } else if (Status error = collect(statistics)) {
      return error;
    }
    const ValueStep value_step = step_for(statistics);
    if (!value_step.is_finer_than_noise) return too_coarse(where_, statistics);
    step_ = value_step.step;
    const double noise = statistics.noise();
    opened.notices.push_back("values were scaled: one voxel unit is " + rounded_text(step_) +
                             " of the file's units; rounding error at most " + rounded_text(0.5 * step_) +
                             ", noise " + rounded_text(noise));
    return std::nullopt;
  }

  /// Converts a stored number to a voxel; false if it does not fit into int16.
  bool voxel_of(const DicomSlice& slice, std::int32_t stored, std::int16_t& voxel) const {
    double value = keeps_stored_ ? stored : slice.slope * stored + slice.intercept;
    if (step_ > 0) value = std::floor(value / step_ + 0.5);
    if (!(value >= -32768 && value <= 32767)) return false;
    voxel = static_cast<std::int16_t>(value);
    return true;
  }

  /// Reads a plain 16-bit slice whose slope and intercept are whole numbers, fast. Returns false for other
  /// slices, if padding is mapped to air, or if a value does not fit into int16.
  bool read_usual_slice(const DicomPixels& pixels, const DicomSlice& slice, std::int16_t* voxels,
                        std::size_t& padding) const {
    const bool is_whole = slice.slope == std::floor(slice.slope) &&
                          slice.intercept == std::floor(slice.intercept) && std::abs(slice.slope) < 256 &&
                          std::abs(slice.intercept) < 1e6;
    if (step_ > 0 || keeps_stored_ || !is_whole || options_->maps_padding ||
        !pixels.read_plain(slice, voxels))
      return false;
    const int slope = static_cast<int>(slice.slope), intercept = static_cast<int>(slice.intercept);
    const int unused_bits = 32 - slice.bits_stored;
    const int low = slice.padding ? slice.padding->first : 1,
              high = slice.padding ? slice.padding->second : 0;
    const std::size_t count = static_cast<std::size_t>(slice.rows) * static_cast<std::size_t>(slice.columns);
    int lowest = 0, highest = 0;
    std::uint32_t padding_count = 0;
    const auto convert = [&](auto number_of) {
      for (std::size_t i = 0; i < count; ++i) {
        const int stored = number_of(static_cast<std::uint32_t>(static_cast<std::uint16_t>(voxels[i])));
        padding_count +=
            static_cast<std::uint32_t>(stored >= low) & static_cast<std::uint32_t>(stored <= high);
        const int value = slope * stored + intercept;
        lowest = std::min(lowest, value);
        highest = std::max(highest, value);
        voxels[i] = static_cast<std::int16_t>(value);
      }
    };
    if (slice.is_signed)
      convert(
          [unused_bits](std::uint32_t raw) { return static_cast<int>(raw << unused_bits) >> unused_bits; });
    else
      convert(
          [unused_bits](std::uint32_t raw) { return static_cast<int>(raw << unused_bits >> unused_bits); });
    padding = padding_count;
    return lowest >= -32768 && highest <= 32767;
  }

  Status read_slice(const DicomPixels& pixels, const DicomSlice& slice, std::int16_t* voxels,
                    std::vector<std::int32_t>& stored, std::size_t& padding) const {
    if (read_usual_slice(pixels, slice, voxels, padding)) return std::nullopt;
    padding = 0;
    if (std::string reason = pixels.read(slice, stored); !reason.empty()) return slice_error(slice, reason);
    const bool maps_padding = options_->maps_padding && modality() == "CT";
    for (std::size_t i = 0; i < stored.size(); ++i) {
      const bool is_padding =
          slice.padding && stored[i] >= slice.padding->first && stored[i] <= slice.padding->second;
      padding += is_padding;
      if (is_padding && maps_padding) {
        voxels[i] = static_cast<std::int16_t>(k_air);
        continue;
      }
      if (voxel_of(slice, stored[i], voxels[i])) continue;
      const double value = slice.slope * stored[i] + slice.intercept;
      return Error{.what = "a value does not fit into 16 bits",
                   .where = where_,
                   .found = rounded_text(value) + " in " + slice.plane.name,
                   .expected = "-32768 to 32767",
                   .remedy = "read it with a coarser step (option scale " +
                             rounded_text(std::ceil(std::abs(value) / 32767)) + ")"};
    }
    return std::nullopt;
  }

  bool is_compressed() const {
    return std::any_of(stack_->slices.begin(), stack_->slices.end(), [this](const DicomSlice& slice) {
      return folder_->entries[slice.entry].file.is_encapsulated;
    });
  }
  /// Reads slice k of the stack from `shared`, or from the slice's own file if `shared` is null.
  Status fill_slice(std::size_t k, const DicomPixels* shared, std::int16_t* voxels, std::size_t area,
                    std::size_t& padding) const {
    const DicomSlice& slice = stack_->slices[static_cast<std::size_t>(geometry_.order[k])];
    thread_local std::vector<std::int32_t> stored;
    DicomPixels own_pixels;
    if (!shared)
      if (std::string reason = DicomPixels::open(folder_->entries[slice.entry], slice, own_pixels);
          !reason.empty())
        return slice_error(slice, reason);
    return read_slice(shared ? *shared : own_pixels, slice, voxels + area * k, stored, padding);
  }

  /// Reads all slices in this process.
  Status fill_in_process(const DicomPixels* shared, std::int16_t* voxels, std::size_t area,
                         std::vector<std::size_t>& padding) const {
    const std::size_t slice_count = stack_->slices.size();
    std::vector<Status> errors(slice_count);
    constexpr std::size_t k_part = 32;
    for (std::size_t begin = 0; begin < slice_count; begin += k_part) {
      if (!report_progress(0.3 + 0.7 * static_cast<double>(begin) / static_cast<double>(slice_count)))
        return reading_interrupted(where_);
      const auto count = static_cast<int>(std::min(k_part, slice_count - begin));
      parallel_for(count, 0, [&](int i) {
        const std::size_t k = begin + static_cast<std::size_t>(i);
        errors[k] = fill_slice(k, shared, voxels, area, padding[k]);
      });
      for (const Status& error : errors)
        if (error) return error;
    }
    return std::nullopt;
  }

  /// Reads all slices in child processes, because damaged compressed pixels may crash GDCM.
  Status fill_in_subprocess(const DicomPixels* shared, std::int16_t* voxels, std::size_t area,
                            std::vector<std::size_t>& padding) const {
    struct SliceResult {
      std::size_t padding;
      char parts[4][256];  ///< texts of an error
    };
    const std::size_t slice_count = stack_->slices.size(), bytes = 2 * area * slice_count;
    const auto shared_voxels = SharedBytes::make(bytes),
               results = SharedBytes::make(sizeof(SliceResult) * slice_count);
    if (!shared_voxels || !results) return too_large(bytes, where_);
    auto* slice_results = reinterpret_cast<SliceResult*>(results->data());
    const SubprocessResult result = run_in_subprocess(
        static_cast<int>(slice_count),
        [&](int i) {
          const auto k = static_cast<std::size_t>(i);
          const Status error = fill_slice(k, shared, reinterpret_cast<std::int16_t*>(shared_voxels->data()),
                                          area, slice_results[k].padding);
          if (!error) return;
          const std::string* parts[] = {&error->what, &error->found, &error->expected, &error->remedy};
          for (std::size_t p = 0; p < 4; ++p)
            parts[p]->copy(slice_results[k].parts[p], sizeof slice_results[k].parts[p] - 1);
        },
        [this](double share) { return report_progress(0.3 + 0.7 * share); });
    if (result.end == SubprocessResult::End::stopped) return reading_interrupted(where_);
    if (result.end == SubprocessResult::End::failed)
      return slice_error(stack_->slices[static_cast<std::size_t>(
                             geometry_.order[static_cast<std::size_t>(std::max(result.at, 0))])],
                         result.found);
    for (std::size_t k = 0; k < slice_count; ++k) {
      if (const auto& parts = slice_results[k].parts; parts[0][0] != '\0')
        return Error{
            .what = parts[0], .where = where_, .found = parts[1], .expected = parts[2], .remedy = parts[3]};
      padding[k] = slice_results[k].padding;
    }
    std::memcpy(voxels, shared_voxels->data(), bytes);
    return std::nullopt;
  }

  Status fill(OpenedVolume& opened) {
    Volume& v = opened.volume;
    const std::size_t area = static_cast<std::size_t>(v.size.x) * static_cast<std::size_t>(v.size.y);
    const std::vector<DicomSlice>& slices = stack_->slices;
    // Slices are read in the order of the stack; for interpolation they are read into a separate buffer.
    Buffer<std::int16_t> inputs;
    if (!geometry_.at.empty()) inputs = Buffer<std::int16_t>(area * slices.size());
    std::int16_t* target = geometry_.at.empty() ? v.voxels.data() : inputs.data();
    std::vector<std::size_t> padding(slices.size(), 0);
    // A file with many frames is opened once; separate files are read in parallel.
    const bool is_one_file = slices.size() > 1 && slices.front().entry == slices.back().entry;
    DicomPixels shared;
    if (is_one_file)
      if (std::string reason = DicomPixels::open(folder_->entries[slices[0].entry], slices[0], shared);
          !reason.empty())
        return slice_error(slices[0], reason);
    if (is_compressed()) {
      if (Status error = fill_in_subprocess(is_one_file ? &shared : nullptr, target, area, padding))
        return error;
    } else if (Status error = fill_in_process(is_one_file ? &shared : nullptr, target, area, padding)) {
      return error;
    }
    for (std::size_t k = 0; k < geometry_.at.size(); ++k) {
      const auto below = static_cast<std::size_t>(geometry_.at[k]);
      const double share = geometry_.at[k] - static_cast<double>(below);
      const std::int16_t *a = inputs.data() + area * below, *b = share > 0 ? a + area : a;
      std::int16_t* out = v.voxels.data() + area * k;
      for (std::size_t i = 0; i < area; ++i)
        out[i] = static_cast<std::int16_t>(std::floor((1 - share) * a[i] + share * b[i] + 0.5));
      interpolated_count_ += share > 0;
    }
    for (const std::size_t n : padding) padding_ += n;
    return std::nullopt;
  }

  void add_notices(OpenedVolume& opened) const {
    const DicomSlice& first = stack_->slices[0];
    if (geometry_.tilt_degrees >= 0.01)
      opened.notices.push_back("the gantry was tilted by " + rounded_text(geometry_.tilt_degrees) +
                               " degrees: slices keep their positions (a sheared volume)");
    if (!geometry_.at.empty())
      opened.notices.push_back(counted(interpolated_count_, "slice") + " of " +
                               std::to_string(geometry_.at.size()) + " were interpolated (option resample)");
    if (opened.volume.size.z == 1)
      opened.notices.push_back(first.plane.thickness > 0
                                   ? "one slice only: its thickness of " +
                                         rounded_text(geometry_.frame.spacing().z) +
                                         " mm is used as the slice distance"
                                   : "one slice only, which does not state its thickness: 1 mm was assumed");
    std::set<std::size_t> files_with_excess;
    for (const DicomSlice& slice : stack_->slices) {
      const DicomEntry& entry = folder_->entries[slice.entry];
      if (!entry.file.is_encapsulated && entry.file.pixel_bytes > expected_pixel_bytes(entry, slice) + 1)
        files_with_excess.insert(slice.entry);
    }
    if (!files_with_excess.empty())
      opened.notices.push_back("excess bytes after the pixels of " +
                               counted(files_with_excess.size(), "file") + " were ignored");
    if (padding_ > 0 && opened.volume.is_hounsfield) {
      std::int16_t value = 0;
      const bool is_convertible = voxel_of(first, first.padding ? first.padding->first : 0, value);
      if (options_->maps_padding)
        opened.notices.push_back(counted(padding_, "voxel") + " of padding became air (-1000)");
      else if (is_convertible && value > -500)
        opened.notices.push_back(counted(padding_, "voxel") + " of padding have the value " +
                                 std::to_string(value) +
                                 ", which is not air: convert it (option padding-to-air)");
    }
    const DicomDataSet& data = data_of(first);
    const std::pair<const char*, DicomTag> public_attributes[] = {{"modality", k_modality},
                                                                  {"manufacturer", k_manufacturer},
                                                                  {"model", k_model},
                                                                  {"kernel", k_kernel},
                                                                  {"kvp", k_kvp},
                                                                  {"slice thickness", k_slice_thickness},
                                                                  {"body part", k_body_part}};
    for (const auto& [name, tag] : public_attributes)
      if (const std::string_view text = data.text(tag); !text.empty()) opened.facts.emplace_back(name, text);
  }

  const DicomFolder* folder_;
  const DicomStack* stack_;
  const OpenOptions* options_;
  std::string where_;
  SliceStack geometry_;
  double step_ = 0;  ///< units per voxel value; 0: unchanged values
  bool keeps_stored_ = false;
  std::size_t padding_ = 0, interpolated_count_ = 0;
};

}  // namespace

Result<OpenedVolume> load_dicom_stack(const DicomFolder& folder, const DicomStack& stack,
                                      const OpenOptions& options, const std::string& where) {
  return Loader(folder, stack, options, where).load();
}

}  // namespace trephine::data_tools
