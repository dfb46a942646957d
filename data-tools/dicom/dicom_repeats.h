// Repeated slices of a DICOM folder: removes copies, splits repetitions, and joins series of single slices.
// Marks are properties that may distinguish slices at one position, such as the echo time
// (DicomSlice::marks).
#pragma once

#include "data-tools/dicom/dicom_series.h"

namespace trephine::data_tools {

/// Returns true if two slices have equal size, spacing and directions.
bool have_same_grid(const DicomSlice& a, const DicomSlice& b);

/// Returns true if at least two of the slices have the same position.
bool has_repeated_positions(const std::vector<DicomSlice>& slices);

/// Keeps one of the slices with equal position, marks and pixels, and removes the others. Returns the names
/// of the removed slices. Reads the files of slices with equal position and marks to hash them. Reads files
/// with equal hashes again to compare them.
std::vector<std::string> drop_copies(const DicomFolder& folder, std::vector<DicomSlice>& slices);

/// Splits a stack into stacks without slices at the same position, and appends them to `stacks`. Splits by
/// the marks from index `mark` on, else by the order of instance numbers. A stack that cannot be split is
/// appended unchanged.
void split_repeats(DicomStack stack, std::size_t mark, std::vector<DicomStack>& stacks);

/// Joins series of one slice each that have equal modality, series number, description and kernel and form
/// one regular stack: some anonymizers assign a different series UID to each slice. Adds a notice.
void join_lone_slices(DicomFolder& folder);

}  // namespace trephine::data_tools
