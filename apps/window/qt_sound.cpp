#include "apps/window/qt_sound.h"

#include <QAudioDeviceInfo>
#include <QAudioOutput>
#include <algorithm>
#include <cmath>

namespace trephine::view {

void DrillVoice::fill(std::int16_t* samples, int count, double force, bool is_pressed, bool has_contact) {
  constexpr double k_two_pi = 6.283185307179586;
  constexpr double k_dt = 1.0 / k_rate;
  if (has_contact && !had_contact_) tick_ = std::min(1.0, 0.35 + 0.3 * force);
  had_contact_ = has_contact;
  // Frequency of the motor, Hz: 0 with the button up, 900 without force, 550 at 8 N; time constant 0.1 s.
  const double target_speed = is_pressed ? 900 - 350 * std::min(force / 8, 1.0) : 0;
  const double load = is_pressed && has_contact ? std::min(force / 4, 1.0) : 0;
  for (int i = 0; i < count; ++i) {
    speed_ += (target_speed - speed_) * std::min(1.0, k_dt / 0.1);
    phase_ = std::fmod(phase_ + k_dt * speed_, 1.0);
    noise_ = noise_ * 1664525u + 1013904223u;
    const double noise = static_cast<double>(noise_ >> 8) / 8388608.0 - 1;
    rattle_ += (noise - rattle_) * 0.35;
    const double hum =
        0.55 * std::sin(k_two_pi * phase_) + 0.25 * std::sin(2 * k_two_pi * phase_) + 0.12 * (2 * phase_ - 1);
    const double loudness = std::min(speed_ / 900, 1.0);
    const double sound =
        loudness * (0.16 * hum + 0.5 * load * rattle_ * (0.6 + 0.4 * std::sin(k_two_pi * phase_))) +
        tick_ * rattle_;
    tick_ *= 1 - std::min(1.0, k_dt / 0.012);
    samples[i] = static_cast<std::int16_t>(std::lround(22000 * std::clamp(sound, -1.0, 1.0)));
  }
}

DrillSound::DrillSound(QObject* parent) : QIODevice(parent) {}
DrillSound::~DrillSound() { stop(); }

bool DrillSound::start() {
  QAudioFormat format;
  format.setSampleRate(DrillVoice::k_rate);
  format.setChannelCount(1);
  format.setSampleSize(16);
  format.setCodec("audio/pcm");
  format.setByteOrder(QAudioFormat::LittleEndian);
  format.setSampleType(QAudioFormat::SignedInt);
  const QAudioDeviceInfo device = QAudioDeviceInfo::defaultOutputDevice();
  if (device.isNull() || !device.isFormatSupported(format)) return false;
  open(QIODevice::ReadOnly);
  output_ = std::make_unique<QAudioOutput>(device, format);
  output_->setBufferSize(2 * DrillVoice::k_rate /
                         20);  // bytes of 50 ms, which the user does not perceive as a delay
  output_->start(this);
  return output_->error() == QAudio::NoError;
}

void DrillSound::stop() {
  output_.reset();
  if (isOpen()) close();
}

void DrillSound::show(double force, bool is_pressed, bool has_contact) {
  force_ = force;
  is_pressed_ = is_pressed;
  has_contact_ = has_contact;
}

qint64 DrillSound::readData(char* data, qint64 max_size) {
  const int count = static_cast<int>(std::min<qint64>(max_size / 2, 2205));
  voice_.fill(reinterpret_cast<std::int16_t*>(data), count, force_, is_pressed_, has_contact_);
  return 2 * count;
}

}  // namespace trephine::view
