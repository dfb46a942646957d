// Slices of a DICOM folder that lie in one place, or were given to series of their own.
#pragma once

#include "data-tools/dicom_series.h"

namespace trephine::data_tools {

/// Have two slices the same size, spacing and directions?
bool are_of_one_grid(const DicomSlice& a, const DicomSlice& b);

/// Do two slices lie in one place?
bool has_doubles(const std::vector<DicomSlice>& slices);

/// Removes all but one of the slices that lie in one place with the same marks and the same pixels. Returns
/// the names of those removed. Reads each file at most once for a hash, and equal ones to compare them.
std::vector<std::string> drop_copies(const DicomFolder& folder, std::vector<DicomSlice>& slices);

/// Appends to `to` the stacks in which no two slices lie in one place, as far as the marks from `mark` on, or
/// the order of instance numbers, distinguish them.
void split_doubles(DicomStack stack, std::size_t mark, std::vector<DicomStack>& to);

/// Joins series of one slice each that agree in kind, number and description and make one regular stack: some
/// programs that remove names give each slice a series UID of its own. Adds a notice.
void join_lone_slices(DicomFolder& folder);

}  // namespace trephine::data_tools
