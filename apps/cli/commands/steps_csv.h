// STEPS.csv: record of a touch, one row per servo step.
#pragma once

#include <charconv>
#include <string>

#include "haptics/servo/servo_loop.h"

namespace trephine::cli {

inline constexpr const char* k_steps_header =
    "t,hip_x,hip_y,hip_z,proxy_x,proxy_y,proxy_z,normal_x,normal_y,normal_z,force_x,force_y,force_z,contact,"
    "shape,side,hand,qx,qy,qz,qw,torque_x,torque_y,torque_z\n";

/// Appends a row: comma separated, decimal point, LF, shortest doubles that read back exactly, flags 0 and 1.
inline void append_step(std::string& out, double t, const haptics::ServoRecord& record,
                        const std::string& shape) {
  const auto put = [&out](double v) {
    char text[40];
    out.append(text, std::to_chars(text, text + sizeof text, v).ptr);
    out.push_back(',');
  };
  put(t);
  for (const glm::dvec3* v :
       {&record.pose.position_world, &record.proxy_world, &record.normal_world, &record.force_world})
    for (int a = 0; a < 3; ++a) put((*v)[a]);
  out += record.has_contact ? "1," : "0,";
  out += record.has_contact ? shape : "";
  out += ',';
  out += record.side == haptics::Side::front ? "front," : record.side == haptics::Side::back ? "back," : ",";
  out += std::to_string(record.hand + 1);
  out += ',';
  const glm::dquat& q = record.pose.orientation;
  for (const double v : {q.x, q.y, q.z, q.w}) put(v);
  for (int a = 0; a < 3; ++a) put(record.torque_world[a]);
  out.back() = '\n';
}

}  // namespace trephine::cli
