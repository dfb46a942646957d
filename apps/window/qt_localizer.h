// Localizer: translates the texts of the libraries, which are English, for display in the window.
#pragma once

#include <QHash>
#include <QString>
#include <QStringList>
#include <QtGlobal>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace trephine::view {

/// A text matches a pattern if they are equal except for the placeholders %1 to %9, which match one or more
/// characters. The placeholders of patterns with few letters, such as "%1 mm" or the joint "%1; %2", match
/// only numbers and texts that match a pattern themselves; those of longer ones match any text within a
/// sentence. Cost: some hundred comparisons per new text; known texts are kept.
class Localizer {
 public:
  /// Returns the translation of a pattern, or an empty text.
  using Translate = std::function<QString(const char* pattern)>;

  Localizer(const std::vector<const char*>& patterns, const Translate& translate, QChar decimal_point);

  /// Returns the translation of a text; a text that matches no pattern is returned unchanged.
  QString translate(const QString& text) const;
  /// True if each line of the text matches a pattern, or is a number.
  bool matches(const QString& text) const;

 private:
  struct Pattern {
    QStringList literals;      ///< parts between the placeholders; first and last may be empty
    std::vector<int> numbers;  ///< of the placeholders, in their order
    QString translation;       ///< with placeholders
    bool is_joint = false;     ///< no letters: punctuation between texts
    bool is_short = false;     ///< few letters or none: its placeholders match only known texts
  };
  std::optional<QString> find(const QString& text) const;
  std::optional<QString> apply(const Pattern& pattern, const QString& text) const;
  bool fill(const Pattern& pattern, const QString& text, int from, std::size_t part,
            std::vector<QString>& captures) const;

  std::vector<Pattern> patterns_;  ///< in the order in which they are tried
  QChar decimal_point_;
  mutable QHash<QString, std::optional<QString>> kept_;  ///< known translations; nullopt: no pattern matches
};

/// Translates a text of the libraries into the language of the application.
QString localized(const QString& text);
inline QString localized(const std::string& text) { return localized(QString::fromStdString(text)); }

/// Selects the language of the application, such as "de"; empty: that of the system. Languages without a
/// catalogue select English. Call once, before the first window.
void select_language(const QString& language);

/// Returns the patterns of the catalogue.
const std::vector<const char*>& message_patterns();

}  // namespace trephine::view
