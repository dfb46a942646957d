// Layout of the picture and its panes: their visibility, sizes, and what is remembered of that.
#pragma once

#include <QSplitter>
#include <array>
#include <functional>

#include "apps/view/qt_image_pane.h"

namespace trephine::view {

/// Arrangements by name.
enum class Layout : std::uint8_t { picture, slices, xray, drawn, depths };
inline constexpr std::array k_layouts{"picture", "slices", "xray", "drawn", "depths"};

/// Two columns: the picture over one pane, two panes. Borders are dragged; one of them alone, and back.
class PaneGrid : public QSplitter {
  Q_OBJECT

 public:
  explicit PaneGrid(imaging::Panes& panes, QWidget* parent = nullptr);

  /// The picture's new canvas; the old one is deleted.
  void set_canvas(QWidget* canvas);
  /// Nothing is made for panes that are not seen.
  void arrange(Layout layout);
  Layout arrangement() const noexcept { return layout_; }
  ImagePane* pane(std::size_t i) const { return panes_[i]; }
  static constexpr std::size_t k_panes = 3;
  /// One alone (0 the picture, then the panes), and back.
  void maximise(int which);
  bool is_maximised() const noexcept { return alone_ >= 0; }

  /// As text, of arrangement, kinds and sizes alone; false: that is no such text, nothing changes.
  QString remember();
  bool restore(const QString& text);

 private:
  void show_what_is_seen();
  /// Positions of the borders between visible panes.
  void note_shares();

  imaging::Panes* data_;
  QSplitter *left_, *right_;
  QWidget* canvas_ = nullptr;
  std::array<ImagePane*, k_panes> panes_{};
  Layout layout_ = Layout::picture;
  int alone_ = -1;
  std::array<int, 3> shares_{500, 500, 500};  ///< of the first, thousandths: columns, left, right
};

}  // namespace trephine::view
