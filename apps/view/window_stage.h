// States of a window, and what may happen next: one operation at a time, opened in the background, replaced
// when no dialog is open, ended once. No windowing toolkit in here.
#pragma once

namespace trephine::view {

class WindowStage {
 public:
  enum class Stage {
    working,    ///< an operation, a replay, or a picture
    opening,    ///< another operation is being opened in the background
    giving_up,  ///< the opening was cancelled
    closing,    ///< everything has ended
  };
  Stage stage() const noexcept { return stage_; }
  bool is_opening() const noexcept { return stage_ == Stage::opening || stage_ == Stage::giving_up; }

  /// Something is opened; false: not now.
  bool open() noexcept {
    if (stage_ != Stage::working) return false;
    stage_ = Stage::opening;
    return true;
  }
  /// False: nothing was being opened.
  bool give_up() noexcept {
    if (!is_opening()) return false;
    stage_ = Stage::giving_up;
    return true;
  }
  /// May what was opened take the operation's place? Not under a dialog that speaks of that one.
  bool may_replace() const noexcept { return is_opening() && dialogs_ == 0; }
  /// It was opened, or could not be. Is it still wanted?
  bool opened() noexcept {
    const bool is_wanted = stage_ == Stage::opening;
    if (is_opening()) stage_ = Stage::working;
    return is_wanted;
  }
  /// False: it has ended already.
  bool close() noexcept {
    const bool is_first = stage_ != Stage::closing;
    stage_ = Stage::closing;
    return is_first;
  }

  /// A dialog is open, as long as this lives.
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
