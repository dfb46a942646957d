#include "data-tools/dicom/xray_file.h"

#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>

#include "data-tools/dicom/dicom_file.h"
#include "data-tools/dicom/dicom_writer.h"
#include "data-tools/files/atomic_file.h"
#include "data-tools/files/subprocess.h"
#include "data-tools/formats/reader_support.h"
#include "data-tools/formats/write_volume.h"
#include "volume/base/mix_hash.h"

namespace trephine::data_tools {

Result<XrayPose> read_xray_pose(const std::string& path) {
  auto source = ByteSource::open(path);
  if (!source)
    return Error{.what = "the file cannot be read",
                 .where = file_name(path),
                 .found = std::strerror(errno),
                 .expected = "a DICOM file (XA, RF, DX or CR)",
                 .remedy = "check the spelling, and that you may read the file"};
  const auto read = read_dicom_file(std::move(source));
  if (const auto* refusal = std::get_if<DicomFailure>(&read))
    return Error{.what = "the file contains no X-ray image",
                 .where = file_name(path),
                 .found = refusal->found,
                 .expected = "a DICOM file (XA, RF, DX or CR)",
                 .remedy = "copy it again, or pass an X-ray image"};
  const DicomDataSet& data = std::get<DicomFile>(read).data;
  const std::string modality(data.text(dicom_tag::k_modality));
  if (modality != "XA" && modality != "RF" && modality != "DX" && modality != "CR")
    return Error{.what = "the image is not a projection",
                 .where = file_name(path),
                 .found = "modality " + modality,
                 .expected = "XA, RF, DX or CR",
                 .remedy = "pass an X-ray image"};
  XrayPose pose;
  pose.primary = data.number(dicom_tag::k_positioner_primary);
  pose.secondary = data.number(dicom_tag::k_positioner_secondary);
  pose.to_detector = data.number(dicom_tag::k_source_to_detector);
  pose.to_patient = data.number(dicom_tag::k_source_to_patient);
  pose.columns = static_cast<int>(data.number(dicom_tag::k_columns).value_or(0));
  pose.rows = static_cast<int>(data.number(dicom_tag::k_rows).value_or(0));
  const auto down = data.number(dicom_tag::k_imager_spacing, 0),
             right = data.number(dicom_tag::k_imager_spacing, 1);
  if (down && right && std::abs(*down - *right) > 1e-4 * *down)
    return Error{.what = "the pixels are not square",
                 .where = file_name(path),
                 .found = dicom_decimal(*down) + " x " + dicom_decimal(*right) + " mm",
                 .expected = "one spacing",
                 .remedy = "pass an image with square pixels"};
  pose.pixel = down;
  const std::array<std::optional<double>, 3> isocentre{data.number(dicom_tag::k_isocentre, 0),
                                                       data.number(dicom_tag::k_isocentre, 1),
                                                       data.number(dicom_tag::k_isocentre, 2)};
  if (isocentre[0] && isocentre[1] && isocentre[2])
    pose.isocentre = glm::dvec3(*isocentre[0], *isocentre[1], *isocentre[2]);
  for (const auto& value : {pose.primary, pose.secondary, pose.to_detector, pose.to_patient, pose.pixel,
                            isocentre[0], isocentre[1], isocentre[2]})
    if (value && !std::isfinite(*value))
      return Error{.what = "the pose is not finite",
                   .where = file_name(path),
                   .expected = "finite numbers",
                   .remedy = "export the image again"};
  return pose;
}

Status write_xray_file(const std::string& path, const XrayToWrite& xray) {
  MixHash mix;
  mix.add(xray.scan_hash);
  for (const std::uint16_t pixel : xray.pixels) mix.add(std::uint64_t{pixel});
  const std::uint64_t hash = mix.value();
  char name[20];
  std::snprintf(name, sizeof name, "%016llx", static_cast<unsigned long long>(xray.scan_hash));
  const XrayPose& pose = xray.pose;
  const auto text = [](const std::optional<double>& v) { return v ? dicom_decimal(*v) : std::string(); };
  DicomWriter image;
  image.set_anonymous_attributes(name)
      .set(0x0008, 0x0008, "CS", "DERIVED\\SECONDARY\\SINGLE PLANE")
      .set(0x0008, 0x0016, "UI", "1.2.840.10008.5.1.4.1.1.12.1")
      .set(0x0008, 0x0018, "UI", dicom_identifier(hash, 16))
      .set(0x0008, 0x0060, "CS", "XA")
      .set(0x0008, 0x103e, "LO", "trephine X-ray")
      .set(0x0008, 0x2111, "ST", "Computed from a CT by trephine; not for diagnosis")
      .set(0x0018, 0x0060, "DS", dicom_decimal(xray.voltage_kv))
      .set(0x0018, 0x1110, "DS", text(pose.to_detector))
      .set(0x0018, 0x1111, "DS", text(pose.to_patient))
      .set(0x0018, 0x1114, "DS", dicom_decimal(*pose.to_detector / *pose.to_patient))
      .set(0x0018, 0x1150, "IS", std::to_string(std::lround(xray.exposure_ms)))
      .set(0x0018, 0x1151, "IS", std::to_string(std::lround(xray.current_ma)))
      .set(0x0018, 0x1155, "CS", "GR")
      .set(0x0018, 0x115e, "DS", dicom_decimal(xray.area_product / 100))  // mGy cm2 to dGy cm2
      .set(0x0018, 0x1164, "DS", text(pose.pixel) + "\\" + text(pose.pixel))
      .set(0x0018, 0x1500, "CS", "CARM")
      .set(0x0018, 0x1510, "DS", text(pose.primary))
      .set(0x0018, 0x1511, "DS", text(pose.secondary))
      .set(0x0018, 0x1700, "CS", "RECTANGULAR")
      .set(0x0018, 0x1702, "IS", std::to_string(xray.column_low))
      .set(0x0018, 0x1704, "IS", std::to_string(xray.column_high + 1))
      .set(0x0018, 0x1706, "IS", std::to_string(xray.row_low))
      .set(0x0018, 0x1708, "IS", std::to_string(xray.row_high + 1))
      .set(0x0020, 0x000d, "UI", dicom_identifier(xray.scan_hash, 0))
      .set(0x0020, 0x000e, "UI", dicom_identifier(hash, 1))
      .set(0x0020, 0x0013, "IS", "1")
      .set(0x0020, 0x0020, "CS", "")
      .set(0x0020, 0x0052, "UI", dicom_identifier(xray.scan_hash, 2))
      .set_short(0x0028, 0x0002, 1)
      .set(0x0028, 0x0004, "CS", "MONOCHROME2")
      .set_short(0x0028, 0x0010, pose.rows)
      .set_short(0x0028, 0x0011, pose.columns)
      .set_short(0x0028, 0x0100, 16)
      .set_short(0x0028, 0x0101, 16)
      .set_short(0x0028, 0x0102, 15)
      .set_short(0x0028, 0x0103, 0)
      .set(0x0028, 0x1040, "CS", "LOG")
      .set(0x0028, 0x1050, "DS", dicom_decimal(0.5 * (xray.darkest + xray.brightest)))
      .set(0x0028, 0x1051, "DS", dicom_decimal(std::max(1, xray.brightest - xray.darkest)));
  if (pose.isocentre)
    image.set(0x300a, 0x012c, "DS",
              dicom_decimal(pose.isocentre->x) + "\\" + dicom_decimal(pose.isocentre->y) + "\\" +
                  dicom_decimal(pose.isocentre->z));
  image.set_pixels(reinterpret_cast<const std::int16_t*>(xray.pixels.data()), xray.pixels.size());
  return write_atomically(path, [&](const std::string& temporary) -> Status {
    const auto failure_flag = SharedBytes::make(1);
    if (!failure_flag) return too_large(1, file_name(path));
    const SubprocessResult result = run_in_subprocess(
        1,
        [&](int) {
          if (!image.write(temporary) || check_written(temporary, path, 2 * xray.pixels.size()))
            *failure_flag->data() = 1;
        },
        [](double) { return true; });
    if (result.end != SubprocessResult::End::done || *failure_flag->data() != 0)
      return cannot_write(path, ENOSPC);
    return std::nullopt;
  });
}

}  // namespace trephine::data_tools
