#include "apps/window/qt_structure_panel.h"

#include <QCheckBox>
#include <QGridLayout>
#include <QPainter>
#include <QPixmap>
#include <QSlider>
#include <QTimer>
#include <QVBoxLayout>
#include <cmath>

#include "apps/window/qt_localizer.h"

namespace trephine::view {

namespace {

QIcon swatch(const glm::dvec3& colour) {
  QPixmap pixels(16, 16);
  pixels.fill(Qt::transparent);
  QPainter painter(&pixels);
  painter.setRenderHint(QPainter::Antialiasing);
  painter.setBrush(QColor::fromRgbF(colour.r, colour.g, colour.b));
  painter.setPen(QColor(20, 24, 30));
  painter.drawRoundedRect(QRectF(1.5, 1.5, 13, 13), 3, 3);
  return pixels;
}

QString words_of_name(const std::string& name) {
  QString words = QString::fromStdString(name);
  words.replace('_', ' ');
  if (words == "csf") words = "CSF";
  if (!words.isEmpty()) words[0] = words[0].toUpper();
  return localized(words);
}

}  // namespace

StructurePanel::StructurePanel(QWidget* parent) : QWidget(parent) {
  auto* column = new QVBoxLayout(this);
  column->setContentsMargins(0, 0, 0, 0);
}

void StructurePanel::show_list(const std::vector<Structure>& structures) {
  delete rows_;
  rows_ = new QWidget;
  auto* grid = new QGridLayout(rows_);
  grid->setContentsMargins(0, 0, 0, 0);
  grid->setVerticalSpacing(3);
  grid->setColumnStretch(0, 1);
  for (std::size_t i = 0; i < structures.size(); ++i) {
    const Structure& structure = structures[i];
    const int row = static_cast<int>(i);
    const QString name =
        structure.kind == Structure::Kind::all_bone ? tr("Bone") : words_of_name(structure.name);
    auto* shown = new QCheckBox(name);
    shown->setObjectName(QString("structure_%1").arg(row));
    shown->setIcon(swatch(structure.colour));
    shown->setChecked(structure.opacity > 0);
    shown->setFocusPolicy(Qt::NoFocus);
    shown->setToolTip(
        tr("Show or hide this structure in the picture. The tool still touches the same structures."));
    grid->addWidget(shown, row, 0);
    if (structure.is_never_translucent()) {
      connect(shown, &QCheckBox::toggled, this,
              [this, i](bool is_shown) { on_opacity(i, is_shown ? 1.0 : 0.0); });
      continue;
    }
    auto* slider = new QSlider(Qt::Horizontal);
    slider->setObjectName(QString("opacity_%1").arg(row));
    slider->setRange(5, 100);
    slider->setPageStep(15);
    slider->setValue(structure.opacity > 0 ? static_cast<int>(std::lround(100 * structure.opacity)) : 100);
    slider->setEnabled(structure.opacity > 0);
    slider->setMinimumWidth(70);
    slider->setFocusPolicy(Qt::NoFocus);
    slider->setToolTip(tr("Opacity: %1 %").arg(slider->value()));
    grid->addWidget(slider, row, 1);
    const auto send = [this, i, shown, slider] {
      on_opacity(i, shown->isChecked() ? 0.01 * slider->value() : 0.0);
    };
    connect(shown, &QCheckBox::toggled, this, [slider, send](bool is_shown) {
      slider->setEnabled(is_shown);
      send();
    });
    connect(slider, &QSlider::valueChanged, this, [slider, send](int percent) {
      slider->setToolTip(tr("Opacity: %1 %").arg(percent));
      send();
    });
  }
  layout()->addWidget(rows_);
}

}  // namespace trephine::view
