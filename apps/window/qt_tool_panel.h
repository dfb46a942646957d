// ToolPanel and FieldForm: panels from field tables: the instrument in the hand, and commands of any module.
#pragma once

#include <QStringList>
#include <QWidget>
#include <functional>
#include <vector>

#include "apps/view/tool_appearance.h"
#include "sim/api/catalogue.h"

class QComboBox;
class QVBoxLayout;

namespace trephine::view {

class FoldButton;

/// Returns a name as text for the user: "Bone flap" for "bone-flap".
QString words_of(std::string_view name);

/// Returns the label of a field for the user.
QString label_of(const sim::Field& field);
/// Returns true if a field holds a list of positions.
bool is_point_list(const sim::Field& field);
/// Sets a field of a value to a list of positions, or to the first position if it is a field of one position.
void set_positions(sim::Value& value, const sim::Field& field, const std::vector<glm::dvec3>& places);

/// A row for each field of a value. Each widget is named after its field.
class FieldForm : public QWidget {
  Q_OBJECT

 public:
  /// Returns the names to choose from for a text field; empty: the user types the text.
  using Offer = std::function<QStringList(sim::FieldInfo::Names)>;
  /// Lets the user mark the positions of a field in the picture.
  using Mark = std::function<void(const sim::Field&)>;
  /// `mark` null: positions can only be typed.
  explicit FieldForm(const sim::Value& value, const Offer& offer = {}, const Mark& mark = {},
                     QWidget* parent = nullptr);
  const sim::Value& value() const { return value_; }
  /// Shows a value without calling on_change.
  void show(const sim::Value& value);
  /// Shows the rows of expert fields, if there are any.
  void show_more();
  /// Changes the first number field by `steps` steps.
  void step(int steps);
  std::function<void()> on_change = [] {};
  std::function<void()> on_resize = [] {};  ///< rows were shown or hidden

 private:
  void add_row(QWidget* widget, const sim::Field& field, std::function<void()> show);
  QWidget* make_text(const sim::Field& field, const Offer& offer);
  void notify_change() {
    if (!is_showing_) on_change();
  }

  sim::Value value_;
  bool is_showing_ = false;
  std::vector<std::function<void()>> rows_;  ///< each shows its field of value_
  std::function<void(int)> step_ = [](int) {};
  QWidget* expert_ = nullptr;   ///< rows of expert fields; null: no such fields
  FoldButton* more_ = nullptr;  ///< shows or hides these rows
};

/// Picture of the tool, with a scale bar.
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
  ToolAppearance appearance_;
};

/// Controls of an instrument and its parameters.
class ToolPanel : public QWidget {
  Q_OBJECT

 public:
  /// `catalogue` null: only the parameters of the current instrument can be changed.
  explicit ToolPanel(const sim::Catalogue* catalogue, QWidget* parent = nullptr);
  /// Shows the instrument in the hand; empty: no instrument.
  void show(const sim::Value& tool);
  /// Returns the width that the settings of the widest instrument need, pixels.
  int widest() const;
  void step(int steps);
  /// Returns the parameters with which the user may select an instrument, or the reason why this is not
  /// allowed.
  using Permission = std::function<Result<sim::Value, std::string>(const sim::InstrumentType&)>;
  /// Disables instruments that are not permitted, with the reason as tool tip, and offers "No tool". Null:
  /// all instruments are permitted.
  void permit(const Permission& permission);
  /// An empty value removes the instrument.
  std::function<void(sim::Value)> on_change = [](const sim::Value&) {};
  std::function<void()> on_resize = [] {};

 private:
  void rebuild(const sim::Value& tool);

  const sim::Catalogue* catalogue_;
  QVBoxLayout* column_;
  QComboBox* instrument_box_ = nullptr;
  std::vector<sim::Value> instruments_;  ///< instruments with parameters, in the order of the box's items
  bool has_permission_ = false;          ///< a step of a procedure determines instruments and parameters
  FieldForm* form_ = nullptr;
  ToolPicture* picture_ = nullptr;
};

}  // namespace trephine::view
