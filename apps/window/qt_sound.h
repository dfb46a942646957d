// DrillSound: sound of contact and of a drill, synthesised from force and contact; off by default.
#pragma once

#include <QIODevice>
#include <atomic>
#include <cstdint>
#include <memory>
#include <string>

class QAudioOutput;

namespace trephine::view {

/// Synthesises samples of a drill: a motor's hum that drops under load, the rattle of its teeth, and the
/// click of a touch. Deterministic. Not thread-safe.
class DrillVoice {
 public:
  static constexpr int k_rate = 22050;  ///< samples per second
  /// Fills `count` samples. `force`: N; `is_pressed`, `has_contact`: state of the operation.
  void fill(std::int16_t* samples, int count, double force, bool is_pressed, bool has_contact);

 private:
  double phase_ = 0, rattle_ = 0, speed_ = 0, tick_ = 0;
  bool had_contact_ = false;
  std::uint32_t noise_ = 1;
};

/// Plays the voice on the machine's sound device.
class DrillSound : public QIODevice {
  Q_OBJECT

 public:
  explicit DrillSound(QObject* parent = nullptr);
  ~DrillSound() override;
  /// Starts the sound. Returns false if there is no sound device or it does not support the format.
  bool start();
  void stop();
  /// Sets the state for the next samples; parameters as in DrillVoice::fill().
  void show(double force, bool is_pressed, bool has_contact);

 protected:
  qint64 readData(char* data, qint64 max_size) override;
  qint64 writeData(const char*, qint64) override { return -1; }

 private:
  DrillVoice voice_;
  std::unique_ptr<QAudioOutput> output_;
  std::atomic<double> force_{0};
  std::atomic<bool> is_pressed_{false}, has_contact_{false};
};

}  // namespace trephine::view
