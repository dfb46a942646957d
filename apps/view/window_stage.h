// WindowStage: states of a window: one operation at a time, opened in the background, replaced when no dialog
// is open, ended once. Independent of the windowing toolkit.
#pragma once

namespace trephine::view {

class WindowStage {
 public:
  enum class Stage {
    working,     ///< an operation, a replay, or a picture
    opening,     ///< another operation is being opened in the background
    cancelling,  ///< the opening was cancelled
    closing,     ///< everything has ended
  };
  Stage stage() const noexcept { return stage_; }
  bool is_opening() const noexcept { return stage_ == Stage::opening || stage_ == Stage::cancelling; }

  /// Starts opening; returns false if that is not possible now.
  bool open() noexcept {
    if (stage_ != Stage::working) return false;
    stage_ = Stage::opening;
    return true;
  }
  /// Cancels the opening; returns false if nothing is being opened.
  bool cancel() noexcept {
    if (!is_opening()) return false;
    stage_ = Stage::cancelling;
    return true;
  }
  /// True if the opened operation may replace the current one: not while a dialog of the current one is open.
  bool may_replace() const noexcept { return is_opening() && dialogs_ == 0; }
  /// Ends the opening, successful or not. Returns true if it was not cancelled.
  bool opened() noexcept {
    const bool is_wanted = stage_ == Stage::opening;
    if (is_opening()) stage_ = Stage::working;
    return is_wanted;
  }
  /// Closes the window; returns false if it was closed already.
  bool close() noexcept {
    const bool is_first = stage_ != Stage::closing;
    stage_ = Stage::closing;
    return is_first;
  }

  /// Marks a dialog as open during its lifetime.
  class Dialog {
   public:
    explicit Dialog(WindowStage& stage) noexcept : stage_(&stage) { ++stage.dialogs_; }
    ~Dialog() { --stage_->dialogs_; }
    Dialog(const Dialog&) = delete;
    Dialog& operator=(const Dialog&) = delete;

   private:
    WindowStage* stage_;
  };
  bool has_dialog() const noexcept { return dialogs_ > 0; }

 private:
  Stage stage_ = Stage::working;
  int dialogs_ = 0;
};

}  // namespace trephine::view
