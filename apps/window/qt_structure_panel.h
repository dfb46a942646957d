// StructurePanel: list of bone and structures, each with a box to show it and, except for bones without a
// label, a slider for its opacity.
#pragma once

#include <QWidget>
#include <functional>
#include <vector>

#include "apps/view/structures.h"

namespace trephine::view {

class StructurePanel : public QWidget {
  Q_OBJECT

 public:
  explicit StructurePanel(QWidget* parent = nullptr);
  /// Shows a list, in place of the previous one.
  void show_list(const std::vector<Structure>& structures);
  /// The user changed the opacity (0 to 1) of a structure, by its number in the list.
  std::function<void(std::size_t structure, double opacity)> on_opacity = [](std::size_t, double) {};

 private:
  QWidget* rows_ = nullptr;
};

}  // namespace trephine::view
