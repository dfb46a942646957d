// Repeated slices of a DICOM folder: removes copies, splits repetitions, and joins series of single slices.
#pragma once

#include "data-tools/dicom/dicom_series.h"

namespace trephine::data_tools {

/// Returns true if two slices have equal size, spacing and directions.
bool have_same_grid(const DicomSlice& a, const DicomSlice& b);

/// Returns true if two slices have the same position.
bool has_repeated_positions(const std::vector<DicomSlice>& slices);

/// Keeps one of the slices with equal position, marks and pixels, and removes the others. Returns the names
/// of the removed slices. Reads the files of slices with equal position and marks to hash them, and those
/// with equal hashes again to compare them.
std::vector<std::string> drop_copies(const DicomFolder& folder, std::vector<DicomSlice>& slices);

/// Splits a stack into stacks without slices at the same position, by the marks from index `mark` on or by
/// the order of instance numbers, and appends them to `stacks`. A stack that neither distinguishes stays
/// unsplit.
void split_repeats(DicomStack stack, std::size_t mark, std::vector<DicomStack>& stacks);

/// Joins series of one slice each that agree in modality, number, description and kernel and form one regular
/// stack: some anonymizers assign each slice its own series UID. Adds a notice.
void join_lone_slices(DicomFolder& folder);

}  // namespace trephine::data_tools
