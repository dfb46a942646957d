#include "apps/window/qt_localizer.h"

#include <QCoreApplication>
#include <QHash>
#include <QLibraryInfo>
#include <QLocale>
#include <QRegularExpression>
#include <QTranslator>
#include <algorithm>
#include <memory>
#include <optional>
#include <utility>

#include "apps/view/display_text.h"

namespace trephine::view {

namespace {

constexpr int k_short = 8;        // letters; a pattern with fewer ones would match texts by accident
constexpr int k_max_marks = 12;   // of a text that joints divide; longer lists, as of an error, stay English
constexpr int k_max_kept = 5000;  // texts; numbers in messages make many different ones

/// Matches a number, with a unit after a no-break space.
QRegularExpressionMatch match_number(const QString& text) {
  static const QRegularExpression k_number("^([-+]?[0-9]+(?:\\.[0-9]+)?)(?:\u00a0(\\S+))?$");
  return k_number.match(text);
}

/// True for the name of a vertebra, which is the same in all languages.
bool is_vertebra(const QString& text) {
  static const QRegularExpression k_vertebra("^[CTLS][0-9]{1,2}$");
  return k_vertebra.match(text).hasMatch();
}

/// Returns the number of marks at which joints may divide a text.
int mark_count(const QString& text) {
  return text.count(", ") + text.count("; ") + text.count(". ") + text.count(": ");
}

int letter_count(const QString& text) {
  return static_cast<int>(std::count_if(text.begin(), text.end(), [](QChar c) { return c.isLetter(); }));
}

}  // namespace

Localizer::Localizer(const std::vector<const char*>& patterns, const Translate& translate,
                     QChar decimal_point)
    : decimal_point_(decimal_point) {
  static const QRegularExpression k_placeholder("%([1-9])");
  std::vector<std::pair<int, Pattern>> sorted;
  for (const char* source : patterns) {
    const QString text = QString::fromUtf8(source);
    Pattern pattern;
    int end = 0;
    for (auto all = k_placeholder.globalMatch(text); all.hasNext();) {
      const QRegularExpressionMatch one = all.next();
      pattern.literals << text.mid(end, one.capturedStart() - end);
      pattern.numbers.push_back(one.captured(1).toInt());
      end = one.capturedEnd();
    }
    pattern.literals << text.mid(end);
    const int letters = letter_count(pattern.literals.join(""));
    pattern.is_joint = letters == 0 && !pattern.numbers.empty();
    pattern.is_short = letters < k_short;
    pattern.translation = translate(source);
    if (pattern.translation.isEmpty()) pattern.translation = text;
    // Whole texts, then long patterns, then joints, then short patterns.
    constexpr int k_whole = 10000;
    const int order = pattern.numbers.empty() ? k_whole
                      : letters == 0          ? 0
                      : pattern.is_short      ? letters - k_short
                                              : letters;
    // As a part of a list of sentences, a sentence has no full stop.
    if (letters > 0 && text.endsWith('.') && pattern.translation.endsWith('.')) {
      Pattern part = pattern;
      part.literals.last().chop(1), part.translation.chop(1);
      sorted.emplace_back(order, std::move(part));
    }
    sorted.emplace_back(order, std::move(pattern));
  }
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  for (auto& [size, pattern] : sorted) patterns_.push_back(std::move(pattern));
}

QString Localizer::translate(const QString& text) const {
  if (kept_.size() >= k_max_kept) kept_.clear();
  QStringList lines;
  for (const QString& line : text.split('\n')) lines << find(line).value_or(line);
  return lines.join('\n');
}

bool Localizer::matches(const QString& text) const {
  const QStringList lines = text.split('\n');
  return std::all_of(lines.begin(), lines.end(),
                     [this](const QString& line) { return find(line).has_value(); });
}

std::optional<QString> Localizer::find(const QString& text) const {
  if (const QRegularExpressionMatch number = match_number(text); number.hasMatch()) {
    const QString value = number.captured(1).replace('.', decimal_point_), unit = number.captured(2);
    return unit.isEmpty() ? value : value + QChar(0xa0) + find(unit).value_or(unit);
  }
  if (text.isEmpty()) return std::nullopt;
  if (is_vertebra(text)) return text;
  // Joints divide a text at each of their marks: parts are searched once. Placeholders are shorter than the
  // text, so the search ends.
  if (const auto known = kept_.constFind(text); known != kept_.constEnd()) return *known;
  const bool is_list = mark_count(text) > k_max_marks;
  std::optional<QString> found;
  for (const Pattern& pattern : patterns_)
    if (!(is_list && pattern.is_joint) && (found = apply(pattern, text))) break;
  // A name inside a sentence may begin with a small letter; the pattern is that of the name alone.
  if (!found && text[0].isLower())
    for (const Pattern& pattern : patterns_)
      if (pattern.numbers.empty() && pattern.literals[0] == text[0].toUpper() + text.mid(1)) {
        found = pattern.translation;
        break;
      }
  kept_.insert(text, found);
  return found;
}

std::optional<QString> Localizer::apply(const Pattern& pattern, const QString& text) const {
  if (pattern.numbers.empty())
    return pattern.literals[0] == text ? std::optional(pattern.translation) : std::nullopt;
  if (!text.startsWith(pattern.literals.first()) || !text.endsWith(pattern.literals.last()))
    return std::nullopt;
  std::vector<QString> captures(10);
  if (!fill(pattern, text, pattern.literals.first().size(), 0, captures)) return std::nullopt;
  QString result;
  for (int i = 0; i < pattern.translation.size(); ++i) {
    const QChar c = pattern.translation[i];
    const bool is_placeholder = c == '%' && i + 1 < pattern.translation.size() &&
                                pattern.translation[i + 1] >= '1' && pattern.translation[i + 1] <= '9';
    if (!is_placeholder) {
      result += c;
      continue;
    }
    const QString& capture = captures[static_cast<std::size_t>(pattern.translation[++i].digitValue())];
    result += find(capture).value_or(capture);
  }
  return result;
}

/// Fills the placeholders from `part` on with the shortest possible texts, the first of which begins at
/// `from`.
bool Localizer::fill(const Pattern& pattern, const QString& text, int from, std::size_t part,
                     std::vector<QString>& captures) const {
  if (part == pattern.numbers.size()) return from == text.size();
  const QString& next = pattern.literals[static_cast<int>(part) + 1];
  const bool is_last = part + 1 == pattern.numbers.size();
  for (int end = from + 1; end <= text.size(); ++end) {
    end = is_last ? std::max(end, text.size() - next.size()) : text.indexOf(next, end);
    if (end < 0 || text.mid(end, next.size()) != next) return false;
    const QString capture = text.mid(from, end - from);
    // A placeholder of a long pattern may be a name, but no further sentence.
    const bool has_mark = capture.contains("; ") || capture.contains(". ");
    if ((pattern.is_short || has_mark) && !find(capture)) continue;
    captures[static_cast<std::size_t>(pattern.numbers[part])] = capture;
    if (fill(pattern, text, end + next.size(), part + 1, captures)) return true;
  }
  return false;
}

namespace {

/// Null in English.
std::unique_ptr<Localizer>& selected_localizer() {
  static std::unique_ptr<Localizer> k_localizer;
  return k_localizer;
}

}  // namespace

QString localized(const QString& text) {
  const auto& localizer = selected_localizer();
  return localizer ? localizer->translate(text) : text;
}

void select_language(const QString& language) {
  static QTranslator k_own, k_qt;
  const QLocale locale = language.isEmpty() ? QLocale::system() : QLocale(language);
  const bool is_known = locale.language() != QLocale::C && locale.language() != QLocale::English &&
                        k_own.load(locale, "trephine", "_", ":/translations");
  QCoreApplication::removeTranslator(&k_own);
  QCoreApplication::removeTranslator(&k_qt);
  selected_localizer().reset();
  set_display_translation({});
  QLocale shown = is_known ? locale : QLocale(QLocale::English, QLocale::UnitedStates);
  shown.setNumberOptions(QLocale::OmitGroupSeparator);
  QLocale::setDefault(shown);
  if (!is_known) return;
  QCoreApplication::installTranslator(&k_own);
  // The texts of Qt's own dialogs, if Qt's catalogues are installed.
  if (k_qt.load(locale, "qtbase", "_", QLibraryInfo::location(QLibraryInfo::TranslationsPath)))
    QCoreApplication::installTranslator(&k_qt);
  selected_localizer() = std::make_unique<Localizer>(
      message_patterns(), [](const char* pattern) { return k_own.translate("messages", pattern); },
      shown.decimalPoint());
  set_display_translation([](const std::string& english) { return localized(english).toStdString(); });
}

}  // namespace trephine::view
