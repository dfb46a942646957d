// Forces that no surface makes: tracks, springs, vibrations. Each is bounded, and a servo law.
#pragma once

#include <cstdint>
#include <string>
#include <variant>

#include "haptics/force/servo_law.h"

namespace trephine::haptics {

/// Constant force.
struct ConstantForce {
  glm::dvec3 force_world{0.0};  ///< N
};
/// A viscous force against the motion.
struct Viscosity {
  double damping = 0.002;  ///< N s/mm
};
/// To a place.
struct Spring {
  glm::dvec3 anchor_world{0.0};
  double stiffness = 0.1;  ///< N/mm
};
/// A straight track: springs hold the tip on it sideways, and making it longer costs a force, the probe's way
/// through a pedicle (thesis "A Surface-based Volume Haptics Approach", 6.2.3). Going back and forth in what
/// is already made costs none.
struct LineTrack {
  glm::dvec3 start_world{0.0}, ahead_world{0, 0, -1};
  double stiffness = 0.5;  ///< N/mm, sideways and where the track ends
  double resistance = 2;   ///< N, of what is ahead
  int shape = -1;          ///< resists only while the tip is in this shape's solid; -1: everywhere
};
/// A half space that pushes out.
struct PlaneStop {
  glm::dvec3 point_world{0.0}, normal_world{0, 0, 1};
  double stiffness = 0.5;  ///< N/mm
};
/// Shakes to and fro.
struct Vibration {
  glm::dvec3 direction_world{0, 0, 1};
  double amplitude = 0.3;     ///< N
  double frequency_hz = 120;  ///< at most a quarter of the servo's rate
};
/// Carries what the stylus weighs.
struct GravityCompensation {
  double mass = 0.05;  ///< kg
  glm::dvec3 up_world{0, 0, 1};
};
/// Ripples on touched surfaces: a height a sin(2 pi x / wavelength) along a direction, rendered as its slope
/// times the normal force.
struct Texture {
  glm::dvec3 direction_world{1, 0, 0};
  double height = 0.05;   ///< mm
  double wavelength = 1;  ///< mm
};

/// Turns the stylus along a direction, as a drill's guide does: a torque toward where it points (its own -z)
/// along it, and against turning.
struct Align {
  glm::dvec3 direction_world{0, 0, -1};
  double stiffness = 100;  ///< N mm/rad
  double damping = 0.5;    ///< N mm s/rad
};

/// A tool that turns about its axis (the stylus's), clockwise as the hand sees it, while the button is down:
/// what it presses on drags it aside, and shakes it by teeth that come and go.
struct Spin {
  double drag = 0.3;         ///< of what presses it
  double chatter = 0.1;      ///< of what presses it, to and fro
  double frequency_hz = 80;  ///< of that
};

using EffectKind = std::variant<ConstantForce, Viscosity, Spring, LineTrack, PlaneStop, Vibration,
                                GravityCompensation, Texture, Align, Spin>;
struct Effect {
  EffectKind kind;
  double most = 3;  ///< N: never more; of a torque as many hundredths of a newton metre
};

/// "constant, viscous, spring, line, plane, vibration, gravity, texture, align, spin".
std::string effect_names();
/// From words: "spring anchor=0,0,10 stiffness=0.2 most=2". Directions need not be unit. Error names the
/// effect's parameters, or the effects.
volume::Result<Effect> parse_effect(const std::string& text);
/// Error when a value is out of its range.
volume::Status check_effect(const Effect& effect);

/// The effect as a law of a hand. Error when a value is out of its range.
volume::Result<ServoLaw> law_of(const Effect& effect, std::uint32_t id);

}  // namespace trephine::haptics
