#include "apps/window/qt_pane_grid.h"

#include <QStringList>
#include <algorithm>

namespace trephine::view {

using imaging::PaneKind;

PaneGrid::PaneGrid(imaging::Panes& panes, QWidget* parent)
    : QSplitter(Qt::Horizontal, parent), data_(&panes) {
  setObjectName("panes");
  left_ = new QSplitter(Qt::Vertical, this);
  right_ = new QSplitter(Qt::Vertical, this);
  for (std::size_t i = 0; i < k_panes; ++i) {
    panes_[i] = new ImagePane(panes, i);
    panes_[i]->on_maximise = [this, i] { maximise(static_cast<int>(i) + 1); };
    (i == 0 ? left_ : right_)->addWidget(panes_[i]);
  }
  for (QSplitter* splitter : {static_cast<QSplitter*>(this), left_, right_}) {
    splitter->setChildrenCollapsible(false);
    splitter->setHandleWidth(5);
  }
  update_visibility();
}

void PaneGrid::set_canvas(QWidget* canvas) {
  store_shares();
  const QList<int> sizes = left_->sizes();
  delete canvas_;
  canvas_ = canvas;
  left_->insertWidget(0, canvas);
  if (layout_ != Layout::picture) left_->setSizes(sizes);
  update_visibility();
}

void PaneGrid::update_visibility() {
  const auto is_shown = [&](int pane) {  // 0: the picture
    if (maximised_ >= 0) return pane == maximised_;
    return pane == 0 || (layout_ == Layout::slices) || (layout_ == Layout::xray && pane > 1) ||
           ((layout_ == Layout::rendering || layout_ == Layout::depths) && pane == 2);
  };
  if (canvas_) {
    constexpr int k_alone = 320, k_beside = 200;  // pixels, least width
    canvas_->setVisible(is_shown(0));
    canvas_->setMinimumWidth(is_shown(2) || is_shown(3) ? k_beside : k_alone);
  }
  for (std::size_t i = 0; i < k_panes; ++i) panes_[i]->setVisible(is_shown(static_cast<int>(i) + 1));
  left_->setVisible(is_shown(0) || is_shown(1));
  right_->setVisible(is_shown(2) || is_shown(3));
  for (std::size_t i = 0; i < k_panes; ++i)
    data_->set_size(i, panes_[i]->width(), panes_[i]->height(), is_shown(static_cast<int>(i) + 1));
}

void PaneGrid::store_shares() {
  if (maximised_ >= 0) return;
  const QSplitter* splitters[] = {this, left_, right_};
  for (std::size_t i = 0; i < 3; ++i) {
    const QList<int> sizes = splitters[i]->sizes();
    if (sizes.size() == 2 && sizes[0] > 0 && sizes[1] > 0)
      shares_[i] = std::clamp(1000 * sizes[0] / (sizes[0] + sizes[1]), 50, 950);
  }
}

void PaneGrid::arrange(Layout layout) {
  store_shares();
  const bool has_changed = layout != layout_;
  layout_ = layout, maximised_ = -1;
  update_visibility();
  if (!has_changed || layout == Layout::picture) return;
  constexpr PaneKind slices[] = {PaneKind::sagittal, PaneKind::axial, PaneKind::coronal},
                     xray[] = {PaneKind::sagittal, PaneKind::xray, PaneKind::section},
                     rendering[] = {PaneKind::sagittal, PaneKind::rendering, PaneKind::coronal},
                     depths[] = {PaneKind::sagittal, PaneKind::depths, PaneKind::coronal};
  const PaneKind* kinds[] = {nullptr, slices, xray, rendering, depths};
  for (std::size_t i = 0; i < k_panes; ++i) panes_[i]->set_kind(kinds[static_cast<std::size_t>(layout)][i]);
  setSizes(layout == Layout::xray ? QList<int>{620, 380} : QList<int>{500, 500});
  left_->setSizes({500, 500});
  right_->setSizes({500, 500});
}

void PaneGrid::maximise(int pane) {
  store_shares();
  maximised_ = maximised_ == pane ? -1 : pane;
  update_visibility();
}

QString PaneGrid::save_state() {
  store_shares();
  QStringList words{"1", k_layouts[static_cast<std::size_t>(layout_)]};
  for (std::size_t i = 0; i < k_panes; ++i) {
    const std::string_view name = imaging::k_pane_kinds[static_cast<std::size_t>(data_->kind(i))];
    words << QString::fromUtf8(name.data(), static_cast<int>(name.size()));
  }
  for (const int share : shares_) words << QString::number(share);
  return words.join(' ');
}

bool PaneGrid::restore(const QString& text) {
  const QStringList words = text.trimmed().split(' ');
  if (words.size() != 8 || words[0] != "1") return false;
  const auto layout = std::find(k_layouts.begin(), k_layouts.end(), words[1]);
  if (layout == k_layouts.end()) return false;
  std::array<PaneKind, k_panes> kinds{};
  for (std::size_t i = 0; i < k_panes; ++i) {
    const std::string name = words[2 + static_cast<int>(i)].toStdString();
    const auto* kind = std::find(std::begin(imaging::k_pane_kinds), std::end(imaging::k_pane_kinds), name);
    if (kind == std::end(imaging::k_pane_kinds)) return false;
    kinds[i] = static_cast<PaneKind>(kind - std::begin(imaging::k_pane_kinds));
  }
  std::array<int, 3> shares{};
  for (int i = 0; i < 3; ++i) {
    bool is_number = false;
    shares[static_cast<std::size_t>(i)] = words[5 + i].toInt(&is_number);
    if (!is_number || shares[static_cast<std::size_t>(i)] < 0 || shares[static_cast<std::size_t>(i)] > 1000)
      return false;
  }
  arrange(static_cast<Layout>(layout - k_layouts.begin()));
  for (std::size_t i = 0; i < k_panes; ++i) panes_[i]->set_kind(kinds[i]);
  QSplitter* const splitters[] = {this, left_, right_};
  for (std::size_t i = 0; i < 3; ++i) splitters[i]->setSizes({shares[i], 1000 - shares[i]});
  shares_ = shares;
  return true;
}

}  // namespace trephine::view
