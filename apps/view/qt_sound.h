// Sound of contact and of a drill, made from force and touch; off by default.
#pragma once

#include <QIODevice>
#include <atomic>
#include <cstdint>
#include <memory>
#include <string>

class QAudioOutput;

namespace trephine::view {

/// Samples of a drill: a motor's hum that sinks under load, the rattle of its teeth, and the tick of a touch.
/// Deterministic; one thread.
class DrillVoice {
 public:
  static constexpr int k_rate = 22050;  ///< samples a second
  /// `force` N, pressed and cutting as the operation says.
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
  /// False when there is no sound device.
  bool start();
  void stop();
  void show(double force, bool is_pressed, bool has_contact);

 protected:
  qint64 readData(char* data, qint64 most) override;
  qint64 writeData(const char*, qint64) override { return -1; }

 private:
  DrillVoice voice_;
  std::unique_ptr<QAudioOutput> output_;
  std::atomic<double> force_{0};
  std::atomic<bool> is_pressed_{false}, has_contact_{false};
};

}  // namespace trephine::view
