// What effects should add to a force, from their documents (docs/file-formats.md). Shares no code with
// haptics.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

namespace trephine::checker {

/// One effect, its directions of length 1.
struct EffectLaw {
  enum class Kind { constant, viscous, spring, line, plane, vibration, gravity, texture, align, spin };
  Kind kind = Kind::constant;
  glm::dvec3 place{0.0};      ///< anchor, start or point, mm; of a constant one its force, N
  glm::dvec3 direction{0.0};  ///< ahead, normal, up, or along which
  double strength = 0;        ///< N s/mm, N/mm, N, kg, mm, N mm/rad or a share, by its kind
  double other = 0;           ///< resistance N, frequency Hz, wavelength mm or N mm s/rad
  double third = 0;           ///< a share
  double most = 3;            ///< N
  std::uint32_t id = 0;
};

class EffectJudge {
 public:
  EffectJudge(std::vector<EffectLaw> laws, double dt);
  struct Forces {
    glm::dvec3 rendered{0.0}, active{0.0};  ///< N: of springs and dampers, and of what may give energy
  };
  /// Once a tick. `contact_force`: of the surface, before effects; `points`: where the stylus does, of length
  /// 1.
  Forces judge_tick(const glm::dvec3& position, const glm::dvec3& proxy, const glm::dvec3& normal,
                    bool has_contact, const glm::dvec3& contact_force, const glm::dvec3& points = {0, 0, -1},
                    bool is_working = true);
  /// N mm, of those that turn the stylus, in a tick that judge_tick() was told of; `points`: where it points,
  /// of length 1, and by what axis and angle (rad) it turned since the last tick.
  glm::dvec3 torque(const glm::dvec3& points, const glm::dvec3& turned);
  void reset();
  void set(std::vector<EffectLaw> laws);
  /// Is there a tick before the one that judge_tick() was told of last?
  bool has_looked_twice() const { return looks_ > 1; }
  bool is_empty() const { return laws_.empty(); }

 private:
  std::vector<EffectLaw> laws_;
  std::vector<double> track_end_, turns_;  ///< of each; no track: negative
  double dt_;
  glm::dvec3 last_{0.0}, velocity_{0.0}, spin_{0.0};
  bool has_last_ = false;
  long looks_ = 0;
};

}  // namespace trephine::checker
