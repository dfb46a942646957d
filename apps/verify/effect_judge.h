// EffectJudge: forces that effects should add according to docs/file-formats.md. Shares no code with haptics.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

namespace trephine::verify {

/// Parameters of one effect.
struct EffectLaw {
  enum class Kind {
    constant,
    viscous,
    spring,
    line,
    plane,
    vibration,
    gravity,
    texture,
    align,
    spin,
    insertion,
    missing_torque
  };
  Kind kind = Kind::constant;
  glm::dvec3 position{0.0};     ///< anchor, start or point, mm; for a constant effect: its force, N
  glm::dvec3 direction{0.0};    ///< unit: forward, normal, up, or direction of the effect
  double strength = 0;          ///< N s/mm, N/mm, N, kg, mm, N mm/rad, 1/mm or a share, depending on the kind
  double second_parameter = 0;  ///< resistance N, frequency Hz, wavelength mm, N/mm or N mm s/rad
  double third_parameter = 0;   ///< a share for a spin; N mm for a missing torque
  double max_force = 3;         ///< largest force, N
  std::uint32_t id = 0;
};

class EffectJudge {
 public:
  EffectJudge(std::vector<EffectLaw> laws, double dt);
  struct Forces {
    glm::dvec3 rendered{0.0}, active{0.0};  ///< N: of springs and dampers; of effects that may add energy
  };
  /// Returns the forces of one tick. Call once per tick. `contact_force`: force of the surface without
  /// effects, N; `shaft`: unit direction of the stylus; `contact_torque`: torque without effects, N mm.
  Forces judge_tick(const glm::dvec3& position, const glm::dvec3& proxy, const glm::dvec3& normal,
                    bool has_contact, const glm::dvec3& contact_force, const glm::dvec3& shaft = {0, 0, -1},
                    bool is_working = true, const glm::dvec3& contact_torque = glm::dvec3(0));
  /// Returns the torque of the effects that turn the stylus, N mm, in a tick that was passed to judge_tick().
  /// `shaft`: unit direction of the stylus; `rotation`: axis times angle (rad) of its turn since the last
  /// tick.
  glm::dvec3 torque(const glm::dvec3& shaft, const glm::dvec3& rotation);
  void reset();
  /// Sets the effects. An effect with a known id and kind keeps its state.
  void set(std::vector<EffectLaw> laws);
  /// Returns true if judge_tick() was called at least twice since the reset.
  bool has_previous_tick() const { return ticks_ > 1; }
  bool is_empty() const { return laws_.empty(); }

 private:
  std::vector<EffectLaw> laws_;
  std::vector<double> track_end_, turns_;  ///< per law; -1: no track yet
  double dt_;
  glm::dvec3 previous_{0.0}, velocity_{0.0}, spin_{0.0};
  bool has_previous_ = false;
  long ticks_ = 0;
};

}  // namespace trephine::verify
