// Languages of the window: the catalogue of German is complete, and the texts of the libraries match its
// patterns. Also the plain window, which is used where the full window is not installed.
#include <QAbstractButton>
#include <QDomDocument>
#include <QFile>
#include <QGroupBox>
#include <QImage>
#include <QLabel>
#include <QMenuBar>
#include <map>
#include <set>

#include "apps/view/display_text.h"
#include "apps/view/view_window.h"
#include "apps/window/qt_localizer.h"
#include "apps/window/qt_tool_panel.h"
#include "apps/workbench/event_text.h"
#include "data-tools/cases/phantom_cases.h"
#include "data-tools/cases/procedure_file.h"
#include "tests/apps/operation_window_fixture.h"

namespace trephine::view {
namespace {

constexpr const char* k_catalogue = TREPHINE_SOURCE_DIR "/apps/window/languages/trephine_de.ts";

struct Message {
  QString context, source, translation;
  bool is_finished;
};

std::vector<Message> messages_in(const QString& path) {
  QFile file(path);
  EXPECT_TRUE(file.open(QIODevice::ReadOnly)) << path.toStdString();
  QDomDocument document;
  EXPECT_TRUE(document.setContent(&file));
  std::vector<Message> messages;
  const QDomNodeList contexts = document.elementsByTagName("context");
  for (int c = 0; c < contexts.size(); ++c) {
    const QDomElement context = contexts.at(c).toElement();
    for (QDomElement m = context.firstChildElement("message"); !m.isNull();
         m = m.nextSiblingElement("message")) {
      const QDomElement translation = m.firstChildElement("translation");
      messages.push_back({context.firstChildElement("name").text(), m.firstChildElement("source").text(),
                          translation.text(),
                          translation.attribute("type").isEmpty() && !translation.text().isEmpty()});
    }
  }
  return messages;
}

/// Returns the placeholders of a text. In tr(), %1 and %L1 show the same argument.
std::set<QString> placeholders(const QString& text) {
  std::set<QString> found;
  static const QRegularExpression k_placeholder("%L?([1-9])");
  for (auto all = k_placeholder.globalMatch(text); all.hasNext();) found.insert(all.next().captured(1));
  return found;
}

TEST(Localizer, FillsPlaceholdersAndTranslatesThem) {
  const Localizer localizer(
      {"The %1 is %2 mm deep.", "burr", "%1; %2", "%1.", "%1 of %2 parts"},
      [](const char* text) {
        const QString s = text;
        if (s == "burr") return QString("Fräse");
        if (s.startsWith("The")) return QString("Tiefe: %2 mm (%1).");
        return s.contains("parts") ? QString("%1 von %2 Teilen") : QString();
      },
      ',');
  EXPECT_EQ(localizer.translate("The burr is 2.50 mm deep."), "Tiefe: 2,50 mm (Fräse).");
  EXPECT_EQ(localizer.translate("The dura is -1 mm deep."), "Tiefe: -1 mm (dura).");
  EXPECT_EQ(localizer.translate("3 of 4 parts; burr"), "3 von 4 Teilen; Fräse");
  EXPECT_EQ(localizer.translate("burr.\nburr"), "Fräse.\nFräse");
  // A joint translates only what it knows on both sides.
  EXPECT_EQ(localizer.translate("burr; something else"), "burr; something else");
  EXPECT_FALSE(localizer.matches("something else"));
  EXPECT_TRUE(localizer.matches("12.5"));
}

/// A long list of joints has a number of divisions that grows exponentially with its length.
TEST(Localizer, ReturnsUnknownTextsUnchanged) {
  const Localizer localizer(
      {"%1, %2", "%1; %2", "%1. %2", "%1: %2", "a"}, [](const char*) { return QString(); }, '.');
  // Known parts before an unknown one: each division must be tried once only.
  QString numbers = "1";
  for (int i = 0; i < 300; ++i) numbers += ", 1";
  EXPECT_EQ(localizer.translate(numbers + ", b"), numbers + ", b");
  QString few = "1";
  for (int i = 0; i < 11; ++i) few += i % 2 == 0 ? ", 1" : "; 1";
  EXPECT_TRUE(localizer.matches(few));
  EXPECT_EQ(localizer.translate(few + ", b"), few + ", b");
  QString list = "b";
  for (int i = 0; i < 100; ++i) list += i % 2 == 0 ? ", a" : "; b";
  for (const QString& text :
       {QString(), QString(" "), QString("%1"), QString(5000, 'x'), QString("a, a"), QString("a, b"), list})
    EXPECT_EQ(localizer.translate(text), text);
}

/// Each text has a translation with the same placeholders, and the catalogue has the texts of the sources.
TEST(Language, TheCatalogueIsComplete) {
  QTemporaryDir folder;
  const QString copy = folder.filePath("trephine_de.ts");
  ASSERT_TRUE(QFile::copy(k_catalogue, copy));
  ASSERT_EQ(std::system(("cd '" TREPHINE_SOURCE_DIR "' && '" TREPHINE_LUPDATE
                         "' -silent -no-obsolete -locations none -I . apps/window -ts '" +
                         copy.toStdString() + "'")
                            .c_str()),
            0);
  const std::vector<Message> updated = messages_in(copy);
  EXPECT_GT(updated.size(), 900u);
  EXPECT_EQ(updated.size(), messages_in(k_catalogue).size())
      << "the catalogue has texts that no source has: run lupdate with -no-obsolete";
  for (const Message& m : updated) {
    EXPECT_TRUE(m.is_finished) << m.context.toStdString() << ": " << m.source.toStdString();
    EXPECT_EQ(placeholders(m.source), placeholders(m.translation)) << m.source.toStdString();
    EXPECT_EQ(m.source.count('&') > 0, m.translation.count('&') > 0) << m.source.toStdString();
    EXPECT_EQ(m.source.count('\n'), m.translation.count('\n')) << m.source.toStdString();
  }
}

/// Texts that the window shows of instruments, commands, events and procedures match a pattern.
TEST(Language, TextsOfTheLibrariesMatchPatterns) {
  const Localizer localizer(
      message_patterns(), [](const char*) { return QString(); }, '.');
  const auto expect_match = [&](const QString& text) {
    EXPECT_TRUE(text.isEmpty() || localizer.matches(text))
        << "add a pattern to qt_messages.cpp: \"" << text.toStdString() << "\"";
  };
  const auto expect_all = [&](const sim::Schema& schema) {
    expect_match(words_of(schema.name));
    for (const sim::Field& field : schema.fields) {
      expect_match(label_of(field));
      for (const std::string_view text : {field.info.help, field.info.empty_choice})
        expect_match(QString::fromUtf8(text.data(), static_cast<int>(text.size())));
      for (const std::string_view choice : field.info.choices) expect_match(words_of(choice));
    }
  };
  for (const sim::Module* module : modules::catalogue().modules()) {
    for (const sim::InstrumentType* one : module->instruments()) expect_all(*one->parameters->schema);
    for (const sim::ValueType* one : module->commands()) expect_all(*one->schema);
    for (const sim::JobType* one : module->jobs()) expect_all(*one->parameters->schema);
  }
  for (const sim::ValueType* type : modules::catalogue().all()) {
    if (!modules::catalogue().is_event(*type)) continue;
    sim::Value event = sim::Value::of(*type);
    for (const sim::Field& field : type->schema->fields) {
      const auto pointer = field.pointer_in(event.data());
      if (auto* const* text = std::get_if<std::string*>(&pointer)) **text = "dura";
    }
    expect_match(QString::fromStdString(workbench::describe_event({0, 0, {}, event}).text));
  }
  for (const data_tools::ShippedProcedure& shipped : data_tools::shipped_procedures()) {
    const auto file = data_tools::shipped_procedure(std::string(shipped.name));
    ASSERT_TRUE(file);
    expect_match(QString::fromStdString(file.value().procedure.title));
    for (const volume::ProcedureStep& step : file.value().procedure.steps)
      for (const std::string& text : {step.title, step.hint, step.note})
        expect_match(QString::fromStdString(text));
  }
}

/// Names in the plans of the built-in cases, which labels of pictures show, match a pattern.
TEST(Language, NamesOfTheBuiltInCasesMatchPatterns) {
  const Localizer localizer(
      message_patterns(), [](const char*) { return QString(); }, '.');
  std::set<std::string> names;
  for (const char* phantom : {"head", "spine"}) {
    const auto plan = data_tools::phantom_plan(phantom);
    ASSERT_TRUE(plan);
    for (const auto& one : plan->trajectories) names.insert(one.name);
    for (const auto& one : plan->landmarks) names.insert(one.name);
    for (const auto& one : plan->outlines) names.insert(one.name);
    for (const auto& one : plan->structures) names.insert(one.shape.name);
  }
  EXPECT_GT(names.size(), 30u);
  for (const std::string& name : names) {
    const bool is_vertebra = name.size() == 2 && name[0] == 'L';
    EXPECT_TRUE(is_vertebra || localizer.matches(words_of(name)) ||
                localizer.matches(QString::fromStdString(name)))
        << name;
  }
}

/// Sentences that are joined of clauses and reasons are translated as a whole, texts of users not at all.
TEST(Language, SentencesAreTranslatedAsAWhole) {
  std::map<QString, QString> translations;
  for (const Message& m : messages_in(k_catalogue))
    if (m.context == "messages") translations.emplace(m.source, m.translation);
  const Localizer localizer(
      message_patterns(), [&](const char* pattern) { return translations[QString::fromUtf8(pattern)]; }, ',');
  const std::pair<const char*, const char*> sentences[] = {
      {"Flap of 60 by 50 mm; 100 % of tumour exposed, margin 5.0 mm; distance from the plan 1.5 mm on average, "
       "2.0 mm at most.",
       "Deckel von 60 mal 50 mm; 100 % freigelegt (Tumor), Rand 5,0 mm; Abstand vom Plan im Mittel 1,5 mm, "
       "höchstens 2,0 mm."},
      {"Left screw in L4: grade B, breach of 1.5 mm toward the canal. Entry 1.0 mm, tip 2.0 mm from the plan; 80 "
       "of 100 points.",
       "Schraube links in L4: Grad B, Durchbruch von 1,5 mm zum Kanal hin. Eintritt 1,0 mm, Spitze 2,0 mm vom "
       "Plan; 80 von 100 Punkten."},
      {"Screw 3 placed: 6.5 mm in diameter, 45 mm long. It is 4 mm longer than its track.",
       "Schraube 3 gesetzt: Durchmesser 6,5 mm, Länge 45 mm. Sie ist 4 mm länger als ihr Bohrkanal."},
      {"The catheter did not enter: there is bone in the way. Drill a burr hole there first.",
       "Der Katheter drang nicht ein: Knochen ist im Weg. Dort zuerst ein Bohrloch anlegen."},
      {"The tip of the catheter is outside the ventricles; 12 mm below the outer table.",
       "Die Spitze des Katheters liegt außerhalb der Ventrikel; 12 mm unter der Tabula externa."},
      {"12.34\u00a0mm", "12,34\u00a0mm"},
      {"0.00\u00a0degrees", "0,00\u00a0Grad"},
      {"L4: canal gained", "L4: gewonnene Kanalfläche"},
      {"L4 right: tip to plan", "L4 rechts: Spitze zum Plan"},
      {"full at 0.5, none at 2", "voll bei 0,5, keine bei 2"}};
  for (const auto& [english, german] : sentences)
    EXPECT_EQ(localizer.translate(english).toStdString(), german);
  for (const char* own : {"/data/copy of head.nii", "Case of Mr. Smith",
                          "Remove 5 mm of bone behind the sinus", "at least my own step"})
    EXPECT_EQ(localizer.translate(own).toStdString(), own);
}

/// A window in German shows no text that has a different translation.
TEST_F(ToolWindow, SpeaksGerman) {
  std::map<QString, QString> translations;
  for (const Message& m : messages_in(k_catalogue)) translations.emplace(m.source, m.translation);
  select_language("de");
  open("head", drilling::burr({.diameter = 4}));
  std::set<QString> shown;
  for (const auto* widget : window_->findChildren<QWidget*>()) {
    shown.insert(widget->toolTip());
    if (const auto* label = qobject_cast<const QLabel*>(widget)) shown.insert(label->text());
    if (const auto* button = qobject_cast<const QAbstractButton*>(widget)) shown.insert(button->text());
    if (const auto* group = qobject_cast<const QGroupBox*>(widget)) shown.insert(group->title());
    if (const auto* box = qobject_cast<const QComboBox*>(widget))
      for (int i = 0; i < box->count(); ++i) shown.insert(box->itemText(i));
    if (widget->isWindow()) shown.insert(widget->windowTitle());
  }
  for (const auto* action : window_->findChildren<QAction*>()) shown.insert(action->text());
  EXPECT_TRUE(shown.contains("&Datei"));
  EXPECT_TRUE(shown.contains("Fräse"));
  for (const QString& text : shown) {
    const auto found = translations.find(text);
    if (found == translations.end()) continue;
    EXPECT_EQ(found->second, text) << "not translated: " << text.toStdString();
  }
  save_screenshot(*window_, "german");
  // Labels of the picture, messages at the tool and the log are translated, too.
  EXPECT_EQ(display_text("left ventriculostomy"), "linke Ventrikulostomie");
  EXPECT_EQ(localized(std::string("The clutch released after 5.2 mm of bone.")),
            "Die Kupplung löste nach 5,2 mm Knochen aus.");
  window_.reset();
  select_language("en");
  EXPECT_EQ(localized(std::string("The clutch released after 5.2 mm of bone.")),
            "The clutch released after 5.2 mm of bone.");
  EXPECT_EQ(display_text("left ventriculostomy"), "left ventriculostomy");
}

/// The picture is written while the window exists: after the event loop, it has labels but no bone.
TEST_F(Window, ThePlainWindowWritesItsPicture) {
  options_.screenshot = (folder_ / "plain.png").string();
  options_.seconds = 1;
  options_.host = {};
  const auto report = run_plain_window(*scene_, options_);
  ASSERT_TRUE(report) << report.error().message();
  const QImage picture(QString::fromStdString(options_.screenshot));
  ASSERT_FALSE(picture.isNull());
  int bone = 0;
  for (int y = 0; y < picture.height(); ++y)
    for (int x = 0; x < picture.width(); ++x) {
      const QColor colour(picture.pixel(x, y));
      bone += colour.red() > colour.blue() + 30;
    }
  EXPECT_GT(bone, picture.width() * picture.height() / 10);
}

}  // namespace
}  // namespace trephine::view
