// PaneGrid: layout of the picture and its panes: which of them are visible, their sizes, and a text to store
// both.
#pragma once

#include <QSplitter>
#include <array>
#include <functional>

#include "apps/window/qt_image_pane.h"

namespace trephine::view {

/// Arrangements of picture and panes. k_layouts has their names in stored layouts.
enum class Layout : std::uint8_t { picture, slices, xray, rendering, depths };
inline constexpr std::array k_layouts{"picture", "slices", "xray", "drawn", "depths"};

/// Two columns: on the left the picture above one pane, on the right two panes. Borders can be dragged; the
/// picture or any pane can be maximised.
class PaneGrid : public QSplitter {
  Q_OBJECT

 public:
  explicit PaneGrid(imaging::Panes& panes, QWidget* parent = nullptr);

  /// Sets the picture's new canvas and deletes the old one.
  void set_canvas(QWidget* canvas);
  /// Selects an arrangement. Invisible panes get no images.
  void arrange(Layout layout);
  Layout arrangement() const noexcept { return layout_; }
  ImagePane* pane(std::size_t i) const { return panes_[i]; }
  static constexpr std::size_t k_panes = 3;
  /// Maximises the picture (0) or a pane (its index + 1). If this part is maximised already, restores the
  /// arrangement.
  void maximise(int pane);
  bool is_maximised() const noexcept { return maximised_ >= 0; }

  /// Returns arrangement, kinds and sizes as text.
  QString save_state();
  /// Applies the text of save_state(). Returns false, without a change, for an invalid text.
  bool restore(const QString& text);

 private:
  void update_visibility();
  /// Stores the positions of the borders between visible parts in `shares_`.
  void store_shares();

  imaging::Panes* data_;
  QSplitter *left_, *right_;
  QWidget* canvas_ = nullptr;
  std::array<ImagePane*, k_panes> panes_{};
  Layout layout_ = Layout::picture;
  int maximised_ = -1;  ///< maximised part; -1: no part
  /// Share of the first part of each splitter, in thousandths: the two columns, the left column, the right
  /// column.
  std::array<int, 3> shares_{500, 500, 500};
};

}  // namespace trephine::view
