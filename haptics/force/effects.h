// Effect: bounded force of a track, a spring or a vibration, for example, in addition to the forces of
// surfaces. It runs as a servo law.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <variant>

#include "haptics/force/servo_law.h"

namespace trephine::haptics {

/// Constant force.
struct ConstantForce {
  glm::dvec3 force_world{0.0};  ///< N
  friend bool operator==(const ConstantForce&, const ConstantForce&) = default;
};
/// Viscous force against the motion.
struct Viscosity {
  double damping = 0.002;  ///< N s/mm
  friend bool operator==(const Viscosity&, const Viscosity&) = default;
};
/// Spring to a point.
struct Spring {
  glm::dvec3 anchor_world{0.0};
  double stiffness = 0.1;  ///< N/mm
  friend bool operator==(const Spring&, const Spring&) = default;
};
/// Straight track, as a guide: springs hold the tip laterally, and extending the track costs a force. Motion
/// within the existing track is free. A track in matter is an Insertion.
struct LineTrack {
  glm::dvec3 start_world{0.0}, direction_world{0, 0, -1};
  double stiffness = 0.5;  ///< N/mm, lateral and at the end of the track
  double resistance = 2;   ///< N, against extending the track
  friend bool operator==(const LineTrack&, const LineTrack&) = default;
};
/// Half space that pushes the tip out.
struct PlaneStop {
  glm::dvec3 point_world{0.0}, normal_world{0, 0, 1};
  double stiffness = 0.5;  ///< N/mm
  friend bool operator==(const PlaneStop&, const PlaneStop&) = default;
};
/// Oscillating force along a direction.
struct Vibration {
  glm::dvec3 direction_world{0, 0, 1};
  double amplitude = 0.3;     ///< N
  double frequency_hz = 120;  ///< at most a quarter of the servo's rate
  friend bool operator==(const Vibration&, const Vibration&) = default;
};
/// Upward force that carries the weight of the stylus.
struct GravityCompensation {
  double mass = 0.05;  ///< kg
  glm::dvec3 up_world{0, 0, 1};
  friend bool operator==(const GravityCompensation&, const GravityCompensation&) = default;
};
/// Ripples on touched surfaces, with the profile height * sin(2 pi x / wavelength) along a direction.
/// Rendered as their slope times the normal force.
struct Texture {
  glm::dvec3 direction_world{1, 0, 0};
  double height = 0.05;   ///< mm, amplitude
  double wavelength = 1;  ///< mm
  friend bool operator==(const Texture&, const Texture&) = default;
};

/// Aligns the stylus with a direction, like a drill guide: a torque that turns the stylus's own -z axis
/// toward the direction and damps rotation.
struct Align {
  glm::dvec3 direction_world{0, 0, -1};
  double stiffness = 100;  ///< N mm/rad
  double damping = 0.5;    ///< N mm s/rad
  friend bool operator==(const Align&, const Align&) = default;
};

/// Rotation of the tool about the stylus axis, clockwise as viewed from the hand, while the button is
/// pressed: contact drags the tool sideways, and its teeth make it chatter.
struct Spin {
  double drag = 0.3;         ///< lateral force as a share of the contact force
  double chatter = 0.1;      ///< amplitude of the chatter as a share of the contact force
  double frequency_hz = 80;  ///< of the chatter
  friend bool operator==(const Spin&, const Spin&) = default;
};

/// Vibration that stands for a torque which the device cannot render (Kadlecek 2013, 3.7): its amplitude is
/// proportional to that torque, its direction perpendicular to the torque's axis and to the stylus.
struct MissingTorque {
  double gain = 0.005;       ///< N per N mm of missing torque
  double rendered = 0;       ///< N mm, torque that the device renders
  double frequency_hz = 80;  ///< at most a quarter of the servo's rate
  friend bool operator==(const MissingTorque&, const MissingTorque&) = default;
};

/// Matter that resists the tip of an Insertion: an item, or a label of the scene's base.
struct InsertionLayer {
  int item = -1;  ///< index of a shape; -1: `label` is used instead
  int label = -1;
  double puncture = 0;  ///< N, force along the track that is needed to enter the layer for the first time
  double drag = 0;      ///< N, force along the track while it grows in the layer
  friend bool operator==(const InsertionLayer&, const InsertionLayer&) = default;
};

/// Straight track that a tool makes, such as that of a probe in a pedicle (Jiang, dissertation, 6.2.3) or of
/// a catheter in the brain. The tip stays on the line and is reported as the proxy. Matter resists only while
/// the track grows: motion within the track is free. Growth of the track always dissipates energy.
struct Insertion {
  static constexpr std::size_t k_max_layers = 4;
  glm::dvec3 start_world{0.0}, direction_world{0, 0, -1};
  double lateral = 2;                                 ///< N/mm, spring to the line
  double along = 1;                                   ///< N/mm, spring to the end of the track
  std::array<InsertionLayer, k_max_layers> layers{};  ///< the first that contains the tip resists
  std::size_t layer_count = 0;
  friend bool operator==(const Insertion&, const Insertion&) = default;
};

using EffectKind = std::variant<ConstantForce, Viscosity, Spring, LineTrack, PlaneStop, Vibration,
                                GravityCompensation, Texture, Align, Spin, Insertion, MissingTorque>;
struct Effect {
  EffectKind kind;
  double max_force = 3;  ///< largest force, N; of Align: largest torque, N mm, divided by 10 mm
  friend bool operator==(const Effect&, const Effect&) = default;
};

/// Returns "constant, viscous, spring, line, plane, vibration, gravity, texture, align, spin, insertion,
/// missing-torque".
std::string effect_names();
/// Parses a text such as "spring anchor=0,0,10 stiffness=0.2 most=2". Directions need not be unit vectors.
/// The error names the parameters of the effect, or all effects.
Result<Effect> parse_effect(const std::string& text);
/// Returns the text of an effect, which parse_effect() reads.
std::string words_of(const Effect& effect);
/// Returns an error if a value is out of its range.
Status check_effect(const Effect& effect);

/// Returns the effect as a law of a hand. Error if a value is out of its range.
Result<ServoLaw> law_of(const Effect& effect, std::uint32_t id);

}  // namespace trephine::haptics
