// Panels from tables: the instrument in the hand and the commands of modules, whichever they are.
#pragma once

#include <QStringList>
#include <QWidget>
#include <functional>
#include <vector>

#include "apps/view/tool_look.h"
#include "sim/catalogue.h"

class QComboBox;
class QVBoxLayout;

namespace trephine::view {

/// "bone-flap" as people read it: "Bone flap".
QString words_of(std::string_view name);

/// A row for each field of a value. Each widget is named after its field.
class FieldForm : public QWidget {
  Q_OBJECT

 public:
  /// Returns the names to offer for a text; of no kind: none.
  using Offer = std::function<QStringList(sim::FieldInfo::Names)>;
  explicit FieldForm(const sim::Value& value, const Offer& offer = {}, QWidget* parent = nullptr);
  const sim::Value& value() const { return value_; }
  /// Without a word to on_change.
  void show(const sim::Value& value);
  /// The first number a step up or down.
  void step(int steps);
  std::function<void()> on_change = [] {};
  std::function<void()> on_resize = [] {};  ///< rows came or went

 private:
  void add_row(QWidget* widget, const sim::Field& field, std::function<void()> show);
  QWidget* make_text(const sim::Field& field, const Offer& offer);
  void changed() {
    if (!is_showing_) on_change();
  }

  sim::Value value_;
  bool is_showing_ = false;
  std::vector<std::function<void()>> rows_;  ///< show what value_ has
  std::function<void(int)> step_ = [](int) {};
  QWidget* expert_ = nullptr;  ///< its rows are shown on request; null: no such rows
};

/// Picture of the tool in its size, with a bar of a millimetre count.
class ToolPicture : public QWidget {
  Q_OBJECT

 public:
  explicit ToolPicture(QWidget* parent = nullptr);
  void show_tool(const sim::Value& tool);
  QSize sizeHint() const override { return {200, 64}; }
  QSize minimumSizeHint() const override { return {120, 64}; }

 protected:
  void paintEvent(QPaintEvent* event) override;

 private:
  ToolLook look_;
};

/// The first hand's instrument and its parameters.
class ToolPanel : public QWidget {
  Q_OBJECT

 public:
  /// Null: the instrument stays, its parameters change.
  explicit ToolPanel(const sim::Catalogue* catalogue, QWidget* parent = nullptr);
  /// The instrument in the hand; empty: without one.
  void show(const sim::Value& tool);
  void step(int steps);
  std::function<void(sim::Value)> on_change = [](const sim::Value&) {};
  std::function<void()> on_resize = [] {};

 private:
  void rebuild(const sim::Value& tool);

  const sim::Catalogue* catalogue_;
  QVBoxLayout* column_;
  QComboBox* which_ = nullptr;
  FieldForm* form_ = nullptr;
  ToolPicture* picture_ = nullptr;
};

}  // namespace trephine::view
