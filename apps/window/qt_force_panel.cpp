#include "apps/window/qt_force_panel.h"

#include <QHBoxLayout>
#include <QHeaderView>
#include <QLabel>
#include <QPushButton>
#include <QTableWidget>
#include <QVBoxLayout>
#include <algorithm>
#include <glm/geometric.hpp>

#include "apps/window/qt_localizer.h"
#include "apps/workbench/force_text.h"

namespace trephine::view {

namespace {
enum Column { name, x, y, z, size, torque, column_count };
}

ForcePanel::ForcePanel(QWidget* parent)
    : QDockWidget(tr("Why this force?"), parent),
      text_(new QLabel),
      table_(new QTableWidget(0, column_count)) {
  setObjectName("force_panel");
  text_->setObjectName("force_text");
  text_->setWordWrap(true);
  table_->setObjectName("force_table");
  table_->setHorizontalHeaderLabels(
      {tr("part"), tr("left, N"), tr("back, N"), tr("up, N"), tr("size, N"), tr("torque, N mm")});
  table_->verticalHeader()->hide();
  table_->setEditTriggers(QAbstractItemView::NoEditTriggers);
  table_->setSelectionMode(QAbstractItemView::NoSelection);
  table_->setFocusPolicy(Qt::NoFocus);
  table_->horizontalHeader()->setSectionResizeMode(QHeaderView::ResizeToContents);
  table_->horizontalHeader()->setSectionResizeMode(name, QHeaderView::Stretch);
  auto* content = new QWidget;
  auto* column = new QVBoxLayout(content);
  auto* row = new QHBoxLayout;
  const auto add = [&](const char* id, const QString& words, int ticks) {
    auto* button = new QPushButton(words);
    button->setObjectName(id);
    button->setFocusPolicy(Qt::NoFocus);
    connect(button, &QPushButton::clicked, this, [this, ticks] { on_step(ticks); });
    row->addWidget(button);
  };
  add("previous_tick", tr("Previous tick"), -1);
  add("next_tick", tr("Next tick"), 1);
  row->addStretch(1);
  column->addWidget(text_);
  column->addWidget(table_, 1);
  column->addLayout(row);
  setWidget(content);
  connect(this, &QDockWidget::visibilityChanged, this, [this](bool is_visible) { on_visible(is_visible); });
  hide();
}

void ForcePanel::show_parts(const std::optional<haptics::ForceParts>& parts, const haptics::TouchScene& scene,
                            bool is_playing) {
  if (!parts) {
    shown_.reset();
    table_->setRowCount(0);
    text_->setText(is_playing ? tr("Pause the replay to see the parts of the force.")
                              : tr("The replay is before its first tick."));
    return;
  }
  if (shown_ == parts->record.tick) return;
  shown_ = parts->record.tick;
  QString text = tr("Tick %1, %L2 s.").arg(parts->record.tick).arg(parts->record.t, 0, 'f', 3);
  for (const std::string& line : workbench::force_sentences(*parts, scene)) text += "\n" + localized(line);
  text_->setText(text);
  const int count = static_cast<int>(parts->parts.size());
  table_->setRowCount(count + 1);
  const auto fill = [this](int row, const QString& words, const haptics::Wrench& wrench, bool is_sum) {
    const glm::dvec3& force = wrench.force_world;
    const double torque_size = glm::length(wrench.torque_world);
    const QString cells[] = {words,
                             QLocale().toString(force.x, 'f', 3),
                             QLocale().toString(force.y, 'f', 3),
                             QLocale().toString(force.z, 'f', 3),
                             QLocale().toString(glm::length(force), 'f', 3),
                             torque_size > 0 ? QLocale().toString(torque_size, 'f', 2) : QString("\u2013")};
    for (int c = 0; c < column_count; ++c) {
      auto* item = new QTableWidgetItem(cells[c]);
      item->setTextAlignment(c == name ? Qt::AlignLeft | Qt::AlignVCenter
                                       : Qt::AlignRight | Qt::AlignVCenter);
      if (c == name) item->setToolTip(words);
      if (is_sum) {
        QFont font = item->font();
        font.setBold(true);
        item->setFont(font);
      }
      table_->setItem(row, c, item);
    }
  };
  for (int i = 0; i < count; ++i) {
    const haptics::ForcePart& part = parts->parts[static_cast<std::size_t>(i)];
    // The cell of an effect shows only the first word, its name. The tool tip also shows its parameters.
    fill(i, localized(part.name), part.wrench, false);
    if (part.kind == haptics::ForcePart::Kind::effect)
      table_->item(i, name)->setText(QString::fromStdString(part.name).section(' ', 0, 0));
  }
  fill(count, tr("sum"), parts->record.wrench(), true);
  const auto has_torque = [](const haptics::ForcePart& part) {
    return part.wrench.torque_world != glm::dvec3(0);
  };
  fit_heights();
  table_->setColumnHidden(torque, std::none_of(parts->parts.begin(), parts->parts.end(), has_torque));
}

/// Reserves the height of the whole text, and that of the table's first rows: a dock does not ask a wrapped
/// text for its height.
void ForcePanel::fit_heights() {
  constexpr int k_rows = 5;
  text_->setMinimumHeight(std::max(0, text_->heightForWidth(text_->width())));
  const int rows = std::min(table_->rowCount(), k_rows);
  table_->setMinimumHeight(table_->horizontalHeader()->sizeHint().height() +
                           rows * table_->verticalHeader()->defaultSectionSize() + 2 * table_->frameWidth());
}

void ForcePanel::resizeEvent(QResizeEvent* event) {
  QDockWidget::resizeEvent(event);
  fit_heights();
}

}  // namespace trephine::view
