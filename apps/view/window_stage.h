// WindowStage: stages of a window. A window has one operation at a time. Another operation is opened in the
// background, and replaces the current one when no dialog is open. Independent of the windowing toolkit.
#pragma once

namespace trephine::view {

class WindowStage {
 public:
  enum class Stage {
    working,     ///< an operation, a replay, or a picture
    opening,     ///< another operation is being opened in the background
    cancelling,  ///< the opening was cancelled
    closing,     ///< the window was closed
  };
  Stage stage() const noexcept { return stage_; }
  bool is_opening() const noexcept { return stage_ == Stage::opening || stage_ == Stage::cancelling; }

  /// Starts the opening of another operation; returns false if one is being opened or the window was closed.
  bool open() noexcept {
    if (stage_ != Stage::working) return false;
    stage_ = Stage::opening;
    return true;
  }
  /// Cancels the opening; returns false if no operation is being opened.
  bool cancel() noexcept {
    if (!is_opening()) return false;
    stage_ = Stage::cancelling;
    return true;
  }
  /// Returns true if an operation is being opened and no dialog is open. Only then may the opened operation
  /// replace the current one.
  bool may_replace() const noexcept { return is_opening() && dialogs_ == 0; }
  /// Ends the opening, successful or not. Returns true if it was not cancelled.
  bool opened() noexcept {
    const bool is_wanted = stage_ == Stage::opening;
    if (is_opening()) stage_ = Stage::working;
    return is_wanted;
  }
  /// Marks the window as closed; returns false if it was closed already.
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
