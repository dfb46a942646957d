#include "apps/window/qt_tool_panel.h"

#include <QAction>
#include <QCheckBox>
#include <QComboBox>
#include <QDoubleSpinBox>
#include <QFormLayout>
#include <QLineEdit>
#include <QLinearGradient>
#include <QPainter>
#include <QPixmap>
#include <QPolygonF>
#include <QStandardItemModel>
#include <QVBoxLayout>
#include <algorithm>

#include "apps/window/qt_localizer.h"
#include "apps/window/qt_panels.h"

namespace trephine::view {

namespace {

QString text_of(std::string_view words) {
  return QString::fromUtf8(words.data(), static_cast<int>(words.size()));
}

/// Number field that omits trailing zeros.
class NumberBox : public QDoubleSpinBox {
 public:
  explicit NumberBox(const sim::FieldInfo& info) {
    setDecimals(3);
    setRange(std::max(info.low, -1e6), std::min(info.high, 1e6));
    if (info.low > 0 && info.low < 1e-3) setMinimum(1e-3);
    if (!info.unit.empty()) setSuffix(" " + localized(text_of(info.unit)).replace("mm3", "mm\u00b3"));
    setSingleStep(info.unit == "mm" ? 0.5 : 1);
    setKeyboardTracking(false);
  }
  /// A point is a decimal point in every language.
  QValidator::State validate(QString& text, int& position) const override {
    text.replace('.', locale().decimalPoint());
    return QDoubleSpinBox::validate(text, position);
  }
  QString textFromValue(double value) const override { return locale().toString(value, 'g', 7); }
};

/// Returns a pointer to a field of a value.
template <class T>
T* address_of(const sim::Field& field, sim::Value& value) {
  const auto pointer = field.pointer_in(value.data());
  return *std::get_if<T*>(&pointer);
}

}  // namespace

QString words_of(std::string_view name) {
  QString words = text_of(name);
  for (QChar& c : words)
    if (c == '-' || c == '_') c = ' ';
  if (!words.isEmpty()) words[0] = words[0].toUpper();
  return localized(words);
}

QString label_of(const sim::Field& field) {
  return field.info.label.empty() ? words_of(field.name) : localized(text_of(field.info.label));
}

namespace {
/// Adds a button to a line edit. By this button the user marks the positions of the field in the picture.
void add_mark_button(QLineEdit* line, const sim::Field& field, const FieldForm::Mark& mark) {
  QPixmap cross(16, 16);
  cross.fill(Qt::transparent);
  QPainter painter(&cross);
  painter.setPen(QPen(QColor(246, 201, 68), 1.6));
  painter.drawEllipse(QPointF(8, 8), 4.5, 4.5);
  painter.drawLine(8, 0, 8, 16);
  painter.drawLine(0, 8, 16, 8);
  painter.end();
  constexpr int k_letters = 22;  // a position: "-123.45,-123.45,123.45"
  line->setMinimumWidth(k_letters * line->fontMetrics().averageCharWidth() + 40);
  QAction* action = line->addAction(QIcon(cross), QLineEdit::TrailingPosition);
  action->setObjectName("mark_" + text_of(field.name));
  action->setToolTip(QObject::tr("Mark this field's positions in the picture or in a slice"));
  QObject::connect(action, &QAction::triggered, line, [mark, &field] { mark(field); });
}
}  // namespace

void FieldForm::add_row(QWidget* widget, const sim::Field& field, std::function<void()> show) {
  widget->setObjectName(text_of(field.name));
  widget->setToolTip(localized(text_of(field.info.help)));
  auto* form = static_cast<QFormLayout*>((field.info.is_expert ? expert_ : this)->layout());
  if (qobject_cast<QCheckBox*>(widget))
    form->addRow(widget);
  else
    form->addRow(label_of(field), widget);
  rows_.push_back(std::move(show));
}

bool is_point_list(const sim::Field& field) {
  return field.type == sim::detail::IndexIn<std::vector<glm::dvec3>, sim::FieldPointer>::k_index;
}

void set_positions(sim::Value& value, const sim::Field& field, const std::vector<glm::dvec3>& places) {
  const sim::FieldPointer pointer = field.pointer_in(value.data());
  if (auto* const* list = std::get_if<std::vector<glm::dvec3>*>(&pointer)) **list = places;
  if (auto* const* point = std::get_if<glm::dvec3*>(&pointer); point && !places.empty())
    **point = places.front();
}

FieldForm::FieldForm(const sim::Value& value, const Offer& offer, const Mark& mark, QWidget* parent)
    : QWidget(parent), value_(value) {
  auto* form = new QFormLayout(this);
  form->setContentsMargins(0, 0, 0, 0);
  const auto& fields = value_.schema().fields;
  if (std::any_of(fields.begin(), fields.end(), [](const sim::Field& f) { return f.info.is_expert; })) {
    expert_ = new QWidget;
    auto* inner = new QFormLayout(expert_);
    inner->setContentsMargins(0, 0, 0, 0);
    expert_->hide();
  }
  bool has_number = false;
  for (const sim::Field& field : fields) {
    const auto pointer = field.pointer_in(value_.data());
    if (std::holds_alternative<double*>(pointer)) {
      auto* box = new NumberBox(field.info);
      if (!has_number) step_ = [box](int steps) { box->stepBy(steps); };
      has_number = true;
      connect(box, QOverload<double>::of(&QDoubleSpinBox::valueChanged), this, [this, &field](double number) {
        *address_of<double>(field, value_) = number;
        notify_change();
      });
      add_row(box, field, [this, box, &field] { box->setValue(*address_of<double>(field, value_)); });
    } else if (std::holds_alternative<bool*>(pointer)) {
      auto* box = new QCheckBox(label_of(field));
      connect(box, &QCheckBox::toggled, this, [this, &field](bool is_on) {
        *address_of<bool>(field, value_) = is_on;
        notify_change();
      });
      add_row(box, field, [this, box, &field] { box->setChecked(*address_of<bool>(field, value_)); });
    } else if (std::holds_alternative<std::uint8_t*>(pointer)) {
      auto* box = new QComboBox;
      const QString unit = field.info.unit.empty() ? QString() : " " + localized(text_of(field.info.unit));
      for (const std::string_view choice : field.info.choices) box->addItem(words_of(choice) + unit);
      connect(box, QOverload<int>::of(&QComboBox::currentIndexChanged), this, [this, &field](int index) {
        *address_of<std::uint8_t>(field, value_) = static_cast<std::uint8_t>(index);
        notify_change();
      });
      add_row(box, field,
              [this, box, &field] { box->setCurrentIndex(*address_of<std::uint8_t>(field, value_)); });
    } else if (std::holds_alternative<std::string*>(pointer)) {
      QWidget* text = make_text(field, offer);
      add_row(text, field, [this, text, &field] {
        const QString current = QString::fromStdString(*address_of<std::string>(field, value_));
        if (auto* line = qobject_cast<QLineEdit*>(text))
          line->setText(current);
        else if (auto* box = qobject_cast<QComboBox*>(text))
          box->setCurrentIndex(box->findData(current));
      });
    } else {
      // Points, lists, whole numbers and ids are edited as text, in the notation of scripts.
      auto* line = new QLineEdit;
      const bool may_be_empty = !field.info.empty_choice.empty();  // an empty text means the number 0
      line->setPlaceholderText(localized(text_of(field.info.empty_choice)));
      connect(line, &QLineEdit::editingFinished, this, [this, line, may_be_empty, &field] {
        const QString text = line->text().trimmed();
        const std::string words =
            std::string(field.name) + "=" + (may_be_empty && text.isEmpty() ? "0" : text.toStdString());
        sim::Value next = value_;
        const Status error = next.set(words);
        line->setStyleSheet(error ? "border: 1px solid #e08030" : "");
        if (error) return line->setToolTip(localized(error->message()));
        line->setToolTip(localized(text_of(field.info.help)));
        if (next == value_) return;
        value_ = std::move(next);
        notify_change();
      });
      const bool is_point = std::holds_alternative<glm::dvec3*>(pointer) || is_point_list(field);
      if (is_point && mark) add_mark_button(line, field, mark);
      add_row(line, field, [this, line, may_be_empty, &field] {
        const QString text = QString::fromStdString(sim::to_words(field, value_.data()));
        line->setText(may_be_empty && text == "0" ? QString() : text);
      });
    }
  }
  show(sim::Value(value_));  // value_ now has the names that combo boxes selected
  if (expert_ == nullptr) return;
  more_ = new FoldButton("more_settings", tr("More settings"));
  more_->on_fold = [this](bool is_open) {
    expert_->setVisible(is_open);
    on_resize();
  };
  form->addRow(more_);
  form->addRow(expert_);
}

void FieldForm::show_more() {
  if (more_ != nullptr && !more_->isChecked()) more_->click();
}

/// Creates a combo box if there are names to choose from, otherwise a line edit.
QWidget* FieldForm::make_text(const sim::Field& field, const Offer& offer) {
  const auto set = [this, &field](const QString& words) {
    std::string text = words.toStdString();
    if (text == *address_of<std::string>(field, value_)) return;
    *address_of<std::string>(field, value_) = std::move(text);
    notify_change();
  };
  const QStringList names = offer ? offer(field.info.names) : QStringList();
  if (!names.isEmpty()) {
    auto* box = new QComboBox;
    if (!field.info.empty_choice.empty())
      box->addItem(localized(text_of(field.info.empty_choice)), QString());
    for (const QString& name : names) box->addItem(name, name);
    connect(box, QOverload<int>::of(&QComboBox::currentIndexChanged), this,
            [box, set] { set(box->currentData().toString()); });
    if (address_of<std::string>(field, value_)->empty()) set(box->currentData().toString());
    return box;
  }
  auto* line = new QLineEdit;
  connect(line, &QLineEdit::editingFinished, this, [line, set] { set(line->text()); });
  return line;
}

void FieldForm::show(const sim::Value& value) {
  value_ = value;
  is_showing_ = true;
  for (const auto& row : rows_) row();
  is_showing_ = false;
  value_ = value;  // restores digits that the boxes rounded
}

void FieldForm::step(int steps) { step_(steps); }

ToolPicture::ToolPicture(QWidget* parent) : QWidget(parent) {
  setObjectName("tool_picture");
  hide();
}

void ToolPicture::show_tool(const sim::Value& tool) {
  appearance_ = appearance_of(tool);
  if (!appearance_.parts.empty()) {  // add a short part of the shaft
    const double from = appearance_.shaft_from, radius = appearance_.shaft_radius;
    appearance_.parts.insert(appearance_.parts.begin(),
                             {{{from, 0}, {from, radius}, {from + 2 * appearance_.radius, radius}},
                              glm::dvec3(0),
                              {0, 0, 1},
                              false});
  }
  setVisible(!appearance_.parts.empty());
  update();
}

/// Draws the tool horizontally, with its tip to the left (z of the tool to the right, x up), without teeth.
void ToolPicture::paintEvent(QPaintEvent*) {
  if (appearance_.parts.empty()) return;
  QPainter painter(this);
  painter.setRenderHint(QPainter::Antialiasing);
  std::vector<QPolygonF> shapes;
  QRectF bounds;
  for (const ToolPart& part : appearance_.parts) {
    const QPointF at(part.at.z, -part.at.x), along(part.along.z, -part.along.x),
        across(-along.y(), along.x());
    QPolygonF shape;
    for (const glm::dvec2& p : part.profile) shape << at + p.x * along + p.y * across;
    for (auto p = part.profile.rbegin(); p != part.profile.rend(); ++p)
      shape << at + p->x * along - p->y * across;
    bounds = bounds.united(shape.boundingRect());
    shapes.push_back(shape);
  }
  const double scale =  // pixels per mm
      std::min((width() - 16) / bounds.width(), (height() - 22) / bounds.height());
  painter.save();
  painter.translate(8 - scale * bounds.left(), 0.5 * (height() - 12) - scale * bounds.center().y());
  painter.scale(scale, scale);
  QPen line(QColor(20, 24, 30), 1);
  line.setCosmetic(true);
  painter.setPen(line);
  QLinearGradient steel(bounds.topLeft(), bounds.bottomLeft());
  steel.setColorAt(0, QColor(235, 238, 244));
  steel.setColorAt(1, QColor(140, 150, 165));
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    painter.setBrush(appearance_.parts[i].is_cutting ? QBrush(steel) : QBrush(QColor(120, 128, 140)));
    painter.drawPolygon(shapes[i]);
  }
  painter.restore();
  // Scale bar.
  const double bar = bounds.width() > 12 ? 5 : bounds.width() > 4 ? 2 : 1;
  const double y = height() - 6;
  painter.setPen(QPen(palette().windowText().color(), 1));
  painter.drawLine(QPointF(8, y), QPointF(8 + scale * bar, y));
  painter.drawText(QPointF(12 + scale * bar, y + 4), QString("%1 mm").arg(bar));
}

ToolPanel::ToolPanel(const sim::Catalogue* catalogue, QWidget* parent)
    : QWidget(parent), catalogue_(catalogue), column_(new QVBoxLayout(this)) {
  column_->setContentsMargins(0, 0, 0, 0);
  picture_ = new ToolPicture;
  if (catalogue_ == nullptr) {
    column_->addWidget(picture_);
    return;
  }
  instrument_box_ = new QComboBox;
  instrument_box_->setObjectName("instrument");
  instrument_box_->setFocusPolicy(Qt::NoFocus);
  instrument_box_->setPlaceholderText(tr("No tool"));
  for (const sim::Module* module : catalogue_->modules())
    for (const sim::InstrumentType* type : module->instruments()) {
      instrument_box_->addItem(words_of(type->name()), text_of(type->name()));
      instruments_.push_back(sim::Value::of(*type->parameters));
    }
  column_->addWidget(instrument_box_);
  column_->addWidget(picture_);
  instrument_box_->setVisible(instrument_box_->count() > 1);
  connect(instrument_box_, QOverload<int>::of(&QComboBox::activated), this, [this](int index) {
    const auto i = static_cast<std::size_t>(index);
    on_change(i < instruments_.size() ? instruments_[i] : sim::Value());
  });
}

void ToolPanel::permit(const Permission& permission) {
  if (instrument_box_ == nullptr) return;
  auto* items = qobject_cast<QStandardItemModel*>(instrument_box_->model());
  for (std::size_t i = 0; i < instruments_.size(); ++i) {
    const sim::InstrumentType* type = catalogue_->find_instrument(instruments_[i].name());
    Result<sim::Value, std::string> parameters = permission        ? permission(*type)
                                                 : has_permission_ ? sim::Value::of(*type->parameters)
                                                                   : instruments_[i];
    QStandardItem* item = items->item(static_cast<int>(i));
    item->setEnabled(parameters.is_ok());
    item->setToolTip(parameters ? QString() : localized(parameters.error()));
    if (parameters) instruments_[i] = std::move(parameters).value();
  }
  has_permission_ = static_cast<bool>(permission);
  // A step may require an empty hand: offer to remove the instrument.
  const int count = static_cast<int>(instruments_.size());
  if (permission && instrument_box_->count() == count) instrument_box_->addItem(tr("No tool"), "");
  if (!permission && instrument_box_->count() > count) instrument_box_->removeItem(count);
  instrument_box_->setVisible(instrument_box_->count() > 1);
}

void ToolPanel::rebuild(const sim::Value& tool) {
  if (form_) form_->deleteLater();
  form_ = nullptr;
  if (tool.is_empty()) return;
  form_ = new FieldForm(tool);
  form_->on_change = [this] { on_change(form_->value()); };
  form_->on_resize = [this] { on_resize(); };
  column_->addWidget(form_);
}

void ToolPanel::show(const sim::Value& tool) {
  picture_->show_tool(tool);
  if (instrument_box_) {
    const int index = instrument_box_->findData(tool.is_empty() ? QString("") : text_of(tool.name()));
    instrument_box_->setCurrentIndex(index);
    // An instrument that is selected again has its last parameters, until a step of a procedure sets others.
    if (!tool.is_empty() && index >= 0) instruments_[static_cast<std::size_t>(index)] = tool;
  }
  const bool is_same_type = form_ && !tool.is_empty() && form_->value().is_of(tool.type());
  if (!is_same_type) return rebuild(tool);
  if (!(form_->value() == tool)) form_->show(tool);
}

int ToolPanel::widest() const {
  int width = 0;
  for (const sim::Value& instrument : instruments_) {
    FieldForm form(instrument);
    form.ensurePolished();
    form.layout()->activate();
    width = std::max(width, form.minimumSizeHint().width());
  }
  return width;
}

void ToolPanel::step(int steps) {
  if (form_) form_->step(steps);
}

}  // namespace trephine::view
