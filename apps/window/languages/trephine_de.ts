<?xml version="1.0" encoding="utf-8"?>
<!DOCTYPE TS>
<TS version="2.1" language="de" sourcelanguage="en">
<context>
    <name>ImagePane</name>
    <message>
        <source>Axial</source>
        <translation>Axial</translation>
    </message>
    <message>
        <source>Coronal</source>
        <translation>Koronal</translation>
    </message>
    <message>
        <source>Sagittal</source>
        <translation>Sagittal</translation>
    </message>
    <message>
        <source>Along the tool</source>
        <translation>Längs des Werkzeugs</translation>
    </message>
    <message>
        <source>Section</source>
        <translation>Schnitt</translation>
    </message>
    <message>
        <source>X-ray</source>
        <translation>Röntgen</translation>
    </message>
    <message>
        <source>Volume rendering</source>
        <translation>Volumenbild</translation>
    </message>
    <message>
        <source>Depth images</source>
        <translation>Tiefenbilder</translation>
    </message>
</context>
<context>
    <name>PaneText</name>
    <message>
        <source>and %1 more</source>
        <translation>und %1 weitere</translation>
    </message>
</context>
<context>
    <name>QObject</name>
    <message>
        <source>%1 s</source>
        <translation>%1 s</translation>
    </message>
    <message>
        <source>%1 min %2 s</source>
        <translation>%1 min %2 s</translation>
    </message>
    <message>
        <source>Mark this field&apos;s positions in the picture or in a slice</source>
        <translation>Die Positionen dieses Feldes im Bild oder in einer Schicht markieren</translation>
    </message>
    <message>
        <source>Opening the device</source>
        <translation>Gerät wird geöffnet</translation>
    </message>
    <message>
        <source>The device is being opened.</source>
        <translation>Das Gerät wird geöffnet.</translation>
    </message>
    <message>
        <source>Cancel</source>
        <translation>Abbrechen</translation>
    </message>
    <message>
        <source>Cancelling ...</source>
        <translation>Wird abgebrochen ...</translation>
    </message>
    <message>
        <source>right</source>
        <translation>rechts</translation>
    </message>
    <message>
        <source>up</source>
        <translation>oben</translation>
    </message>
    <message>
        <source>toward you</source>
        <translation>zu Ihnen</translation>
    </message>
    <message>
        <source>Force (N)</source>
        <translation>Kraft (N)</translation>
    </message>
    <message>
        <source>Torque (N mm)</source>
        <translation>Drehmoment (N mm)</translation>
    </message>
    <message>
        <source>last %1 s</source>
        <translation>letzte %1 s</translation>
    </message>
    <message>
        <source>mean</source>
        <translation>Mittel</translation>
    </message>
    <message>
        <source>mean + deviation</source>
        <translation>Mittel + Abweichung</translation>
    </message>
    <message>
        <source>Virtual device %1</source>
        <translation>Virtuelles Gerät %1</translation>
    </message>
    <message>
        <source>Centre</source>
        <translation>Zur Mitte</translation>
    </message>
    <message>
        <source>Drag: right and up. Drag with the right button: right and toward you. Drag with the middle button, or Ctrl: turn. Wheel: roll. Arrows, Page Up, Page Down: move; with Shift: turn. Space: button of the tool. Home: centre.</source>
        <translation>Ziehen: nach rechts und oben. Mit der rechten Taste ziehen: nach rechts und zu Ihnen. Mit der mittleren Taste oder Strg ziehen: drehen. Rad: rollen. Pfeile, Bild auf, Bild ab: bewegen; mit Umschalt: drehen. Leertaste: Taste des Werkzeugs. Pos1: zur Mitte.</translation>
    </message>
    <message>
        <source>The tool follows a recorded motion or an attached device.</source>
        <translation>Das Werkzeug folgt einer aufgezeichneten Bewegung oder einem angeschlossenen Gerät.</translation>
    </message>
    <message>
        <source>A program uses this device.</source>
        <translation>Ein Programm verwendet dieses Gerät.</translation>
    </message>
    <message>
        <source>No program uses this device. Start one with --device %1.</source>
        <translation>Kein Programm verwendet dieses Gerät. Starten Sie eines mit --device %1.</translation>
    </message>
    <message>
        <source>%1 N   %2 N mm</source>
        <translation>%1 N   %2 N mm</translation>
    </message>
</context>
<context>
    <name>messages</name>
    <message>
        <source>cranial</source>
        <translation>kranial</translation>
    </message>
    <message>
        <source>caudal</source>
        <translation>kaudal</translation>
    </message>
    <message>
        <source>%1; %2</source>
        <translation>%1; %2</translation>
    </message>
    <message>
        <source>%1. %2</source>
        <translation>%1. %2</translation>
    </message>
    <message>
        <source>%1, %2</source>
        <translation>%1, %2</translation>
    </message>
    <message>
        <source>%1.</source>
        <translation>%1.</translation>
    </message>
    <message>
        <source>The force is on again.</source>
        <translation>Die Kraft ist wieder an.</translation>
    </message>
    <message>
        <source>The force is off: %1.</source>
        <translation>Die Kraft ist aus: %1.</translation>
    </message>
    <message>
        <source>the haptic device does not respond</source>
        <translation>das haptische Gerät antwortet nicht</translation>
    </message>
    <message>
        <source>a pose or a force was invalid</source>
        <translation>eine Lage oder Kraft war ungültig</translation>
    </message>
    <message>
        <source>the computation of cuts is too slow</source>
        <translation>die Berechnung der Schnitte ist zu langsam</translation>
    </message>
    <message>
        <source>the computer is too busy</source>
        <translation>der Rechner ist überlastet</translation>
    </message>
    <message>
        <source>A computation was not finished: %1.</source>
        <translation>Eine Berechnung wurde nicht beendet: %1.</translation>
    </message>
    <message>
        <source>The tool reached the %1.</source>
        <translation>Das Werkzeug erreichte: %1.</translation>
    </message>
    <message>
        <source>The tool reached the %1 while it was running.</source>
        <translation>Das laufende Werkzeug erreichte: %1.</translation>
    </message>
    <message>
        <source>The tool left the %1 after %2 s, at most %3 mm deep.</source>
        <translation>Das Werkzeug ist wieder heraus: %1, nach %2 s, höchstens %3 mm tief.</translation>
    </message>
    <message>
        <source>The %1 was pushed aside by %2 mm and did not tear.</source>
        <translation>Weggedrückt, nicht verletzt: %1, um %2 mm.</translation>
    </message>
    <message>
        <source>The running tool touched the %1, %2 mm deep, and did not tear it.</source>
        <translation>Das laufende Werkzeug berührte, ohne zu verletzen: %1, %2 mm tief.</translation>
    </message>
    <message>
        <source>The tool tore the %1 at a depth of %2 mm.</source>
        <translation>Das Werkzeug verletzte: %1, in %2 mm Tiefe.</translation>
    </message>
    <message>
        <source>Implant %1 added, %2 mm³.</source>
        <translation>Implantat %1 eingesetzt, %2 mm³.</translation>
    </message>
    <message>
        <source>Piece %1 detached, %2 mm³.</source>
        <translation>Stück %1 gelöst, %2 mm³.</translation>
    </message>
    <message>
        <source>%1 small parts removed as debris, %2 mm³.</source>
        <translation>%1 kleine Teile als Knochenreste entfernt, %2 mm³.</translation>
    </message>
    <message>
        <source>%1 small part removed as debris, %2 mm³.</source>
        <translation>%1 kleines Teil als Knochenreste entfernt, %2 mm³.</translation>
    </message>
    <message>
        <source>The step %1 began.</source>
        <translation>Der Schritt %1 begann.</translation>
    </message>
    <message>
        <source>%1 was refused in the step %2: %3.</source>
        <translation>%1 wurde im Schritt %2 abgelehnt: %3.</translation>
    </message>
    <message>
        <source>&quot;%1&quot;</source>
        <translation>„%1“</translation>
    </message>
    <message>
        <source>Bone flap of %1 cm² cut, %2 mm³; the saw removed %3 mm³.</source>
        <translation>Knochendeckel von %1 cm² gesägt, %2 mm³; die Säge trug %3 mm³ ab.</translation>
    </message>
    <message>
        <source>Piece %1 of the flap: %2 mm³, %3.</source>
        <translation>Stück %1 des Deckels: %2 mm³, %3.</translation>
    </message>
    <message>
        <source>detached</source>
        <translation>gelöst</translation>
    </message>
    <message>
        <source>left in place</source>
        <translation>bleibt stehen</translation>
    </message>
    <message>
        <source>Preview: %1</source>
        <translation>Vorschau: %1</translation>
    </message>
    <message>
        <source>Preview: no flap. %1</source>
        <translation>Vorschau: kein Deckel. %1</translation>
    </message>
    <message>
        <source>Flap of %1 by %2 mm</source>
        <translation>Deckel von %1 mal %2 mm</translation>
    </message>
    <message>
        <source>%1 % of %2 exposed, margin %3 mm</source>
        <translation>%1 % freigelegt (%2), Rand %3 mm</translation>
    </message>
    <message>
        <source>distance from the plan %1 mm on average, %2 mm at most</source>
        <translation>Abstand vom Plan im Mittel %1 mm, höchstens %2 mm</translation>
    </message>
    <message>
        <source>The saw&apos;s foot stripped the %1 off the bone.</source>
        <translation>Der Fuß der Säge löste vom Knochen: %1.</translation>
    </message>
    <message>
        <source>The saw cut %1 mm into the %2.</source>
        <translation>Die Säge schnitt %1 mm ein: %2.</translation>
    </message>
    <message>
        <source>The saw stayed %1 mm or more from the %2.</source>
        <translation>Die Säge blieb mindestens %1 mm entfernt: %2.</translation>
    </message>
    <message>
        <source>No bone flap: %1</source>
        <translation>Kein Knochendeckel: %1</translation>
    </message>
    <message>
        <source>Section: bone %1 mm², models %2 mm², of which %3 mm² outside bone.</source>
        <translation>Schnitt: Knochen %1 mm², Modelle %2 mm², davon %3 mm² außerhalb des Knochens.</translation>
    </message>
    <message>
        <source>Not measured: %1</source>
        <translation>Nicht gemessen: %1</translation>
    </message>
    <message>
        <source>Measured: %1.</source>
        <translation>Gemessen: %1.</translation>
    </message>
    <message>
        <source>X-ray %1: C-arm %2° %3, %4° %5, %6 mGy cm².</source>
        <translation>Röntgenbild %1: C-Bogen %2° %3, %4° %5, %6 mGy cm².</translation>
    </message>
    <message>
        <source>%1: canal %2 mm² (%3 mm² before), its roof open along %4 mm.</source>
        <translation>%1: Kanal %2 mm² (vorher %3 mm²), Dach auf %4 mm offen.</translation>
    </message>
    <message>
        <source>The laminectomy was not judged: %1.</source>
        <translation>Die Laminektomie wurde nicht beurteilt: %1.</translation>
    </message>
    <message>
        <source>Vertebra %1 was not judged: %2.</source>
        <translation>Wirbel %1 wurde nicht beurteilt: %2.</translation>
    </message>
    <message>
        <source>Vertebra</source>
        <translation>Wirbel</translation>
    </message>
    <message>
        <source>The burr broke through at a thrust of %1 N and plunged %2 mm in %3 s.</source>
        <translation>Die Fräse brach bei %1 N Druck durch und sank in %3 s um %2 mm ein.</translation>
    </message>
    <message>
        <source>The clutch released after %1 mm of bone.</source>
        <translation>Die Kupplung löste nach %1 mm Knochen aus.</translation>
    </message>
    <message>
        <source>The hole here is through the bone already: the clutch does not engage. Widen it with a burr.</source>
        <translation>Das Loch geht hier schon durch den Knochen: Die Kupplung greift nicht. Erweitern Sie es mit einer Fräse.</translation>
    </message>
    <message>
        <source>The craniotome did not cut: %1</source>
        <translation>Das Kraniotom schnitt nicht: %1</translation>
    </message>
    <message>
        <source>Bite of %1 mm³.</source>
        <translation>Biss von %1 mm³.</translation>
    </message>
    <message>
        <source>No bite: %1</source>
        <translation>Kein Biss: %1</translation>
    </message>
    <message>
        <source>The probe entered bone.</source>
        <translation>Die Sonde drang in Knochen ein.</translation>
    </message>
    <message>
        <source>The probe left %1 at a depth of %2 mm, %3.</source>
        <translation>Die Sonde trat aus: %1, in %2 mm Tiefe, %3.</translation>
    </message>
    <message>
        <source>the bone</source>
        <translation>Knochen</translation>
    </message>
    <message>
        <source>toward the canal</source>
        <translation>zum Kanal hin</translation>
    </message>
    <message>
        <source>to the outer side</source>
        <translation>nach außen</translation>
    </message>
    <message>
        <source>toward the head</source>
        <translation>kopfwärts</translation>
    </message>
    <message>
        <source>toward the feet</source>
        <translation>fußwärts</translation>
    </message>
    <message>
        <source>to the front</source>
        <translation>nach vorn</translation>
    </message>
    <message>
        <source>inside bone</source>
        <translation>im Knochen</translation>
    </message>
    <message>
        <source>The probe is in bone again, %1 mm deep.</source>
        <translation>Die Sonde ist wieder im Knochen, %1 mm tief.</translation>
    </message>
    <message>
        <source>Track of %1 mm.</source>
        <translation>Bohrkanal von %1 mm.</translation>
    </message>
    <message>
        <source>Track of %1 mm, %2 mm of it beyond the bone.</source>
        <translation>Bohrkanal von %1 mm, davon %2 mm jenseits des Knochens.</translation>
    </message>
    <message>
        <source>Screw %1 placed: %2 mm in diameter, %3 mm long.</source>
        <translation>Schraube %1 gesetzt: Durchmesser %2 mm, Länge %3 mm.</translation>
    </message>
    <message>
        <source>It is %1 mm longer than its track.</source>
        <translation>Sie ist %1 mm länger als ihr Bohrkanal.</translation>
    </message>
    <message>
        <source>The screw was not placed: %1.</source>
        <translation>Die Schraube wurde nicht gesetzt: %1.</translation>
    </message>
    <message>
        <source>%1 screw in %2: grade %3, no breach, %4 mm in front of the bone.</source>
        <translation>Schraube %1 in %2: Grad %3, kein Durchbruch, %4 mm vor dem Knochen.</translation>
    </message>
    <message>
        <source>%1 screw in %2: grade %3, breach of %4 mm %5.</source>
        <translation>Schraube %1 in %2: Grad %3, Durchbruch von %4 mm %5.</translation>
    </message>
    <message>
        <source>%1 screw: grade %2, no breach, %3 mm in front of the bone.</source>
        <translation>Schraube %1: Grad %2, kein Durchbruch, %3 mm vor dem Knochen.</translation>
    </message>
    <message>
        <source>%1 screw in %2: grade %3, breach of %4 mm %5, %6 mm in front of the bone.</source>
        <translation>Schraube %1 in %2: Grad %3, Durchbruch von %4 mm %5, %6 mm vor dem Knochen.</translation>
    </message>
    <message>
        <source>%1 screw: grade %2, breach of %3 mm %4.</source>
        <translation>Schraube %1: Grad %2, Durchbruch von %3 mm %4.</translation>
    </message>
    <message>
        <source>%1 screw in %2: grade %3, no breach.</source>
        <translation>Schraube %1 in %2: Grad %3, kein Durchbruch.</translation>
    </message>
    <message>
        <source>%1 screw: grade %2, no breach.</source>
        <translation>Schraube %1: Grad %2, kein Durchbruch.</translation>
    </message>
    <message>
        <source>Left</source>
        <translation>links</translation>
    </message>
    <message>
        <source>Right</source>
        <translation>rechts</translation>
    </message>
    <message>
        <source>left</source>
        <translation>links</translation>
    </message>
    <message>
        <source>right</source>
        <translation>rechts</translation>
    </message>
    <message>
        <source>The screw was not judged: %1.</source>
        <translation>Die Schraube wurde nicht beurteilt: %1.</translation>
    </message>
    <message>
        <source>%1 mm in front of the bone</source>
        <translation>%1 mm vor dem Knochen</translation>
    </message>
    <message>
        <source>At this voxel size, grades %1 to %2 are possible</source>
        <translation>Bei dieser Voxelgröße sind die Grade %1 bis %2 möglich</translation>
    </message>
    <message>
        <source>Entry %1 mm, tip %2 mm from the plan</source>
        <translation>Eintritt %1 mm, Spitze %2 mm vom Plan</translation>
    </message>
    <message>
        <source>%1 of 100 points</source>
        <translation>%1 von 100 Punkten</translation>
    </message>
    <message>
        <source>The screw is %1 mm longer than its track</source>
        <translation>Die Schraube ist %1 mm länger als ihr Bohrkanal</translation>
    </message>
    <message>
        <source>The screw is %1 mm shorter than its track</source>
        <translation>Die Schraube ist %1 mm kürzer als ihr Bohrkanal</translation>
    </message>
    <message>
        <source>The catheter reached the dura.</source>
        <translation>Der Katheter erreichte die Dura.</translation>
    </message>
    <message>
        <source>The catheter popped into %1, %2 mm below the outer surface of the dura.</source>
        <translation>Der Katheter drang spürbar ein: %1, %2 mm unter der Oberfläche der Dura.</translation>
    </message>
    <message>
        <source>The catheter was drawn out of the head. Its tip was %1 mm below the outer surface of the dura.</source>
        <translation>Der Katheter wurde aus dem Kopf gezogen. Seine Spitze war %1 mm unter der Oberfläche der Dura.</translation>
    </message>
    <message>
        <source>The catheter did not enter: %1</source>
        <translation>Der Katheter drang nicht ein: %1</translation>
    </message>
    <message>
        <source>The tip of the catheter is outside the ventricles</source>
        <translation>Die Spitze des Katheters liegt außerhalb der Ventrikel</translation>
    </message>
    <message>
        <source>The tip of the catheter is in %1</source>
        <translation>Die Spitze des Katheters liegt in: %1</translation>
    </message>
    <message>
        <source>compared with %1: %2 mm from its target, entry %3 mm from the plan</source>
        <translation>verglichen mit %1: %2 mm vom Ziel, Eintritt %3 mm vom Plan</translation>
    </message>
    <message>
        <source>%1 mm below the outer table</source>
        <translation>%1 mm unter der Tabula externa</translation>
    </message>
    <message>
        <source>%1 mm of the catheter are in %2, up to %3 mm deep.</source>
        <translation>%1 mm des Katheters liegen in: %2, bis %3 mm tief.</translation>
    </message>
    <message>
        <source>The catheter is more than 20 mm away from %1.</source>
        <translation>Der Katheter ist mehr als 20 mm entfernt von: %1.</translation>
    </message>
    <message>
        <source>The catheter is %1 mm away from %2.</source>
        <translation>Der Katheter ist %1 mm entfernt von: %2.</translation>
    </message>
    <message>
        <source>The catheter was left in place, %1 mm below the outer surface of the dura.</source>
        <translation>Der Katheter wurde belassen, %1 mm unter der Oberfläche der Dura.</translation>
    </message>
    <message>
        <source>The catheter was not left in place: %1.</source>
        <translation>Der Katheter wurde nicht belassen: %1.</translation>
    </message>
    <message>
        <source>The path of the catheter crosses %1 mm of %2 (in the scan before the operation).</source>
        <translation>Der Weg des Katheters kreuzt %1 mm: %2 (in der Aufnahme vor der Operation).</translation>
    </message>
    <message>
        <source>Clamp fitted: open %1 mm, its axis %2 mm from the centre of the skull</source>
        <translation>Klemme angepasst: %1 mm geöffnet, Achse %2 mm von der Schädelmitte</translation>
    </message>
    <message>
        <source>The clamp touches the head: %1 mm of its arms are inside the head, at most %2 mm deep.</source>
        <translation>Die Klemme berührt den Kopf: %1 mm ihrer Arme liegen im Kopf, höchstens %2 mm tief.</translation>
    </message>
    <message>
        <source>The clamp was not fitted: %1.</source>
        <translation>Die Klemme wurde nicht angepasst: %1.</translation>
    </message>
    <message>
        <source>No tool is in the hand. Choose one in the panel Tools.</source>
        <translation>Kein Werkzeug in der Hand. Im Feld Werkzeug eines wählen.</translation>
    </message>
    <message>
        <source>The piece is grasped. Press T to release it, Shift+T to put it back.</source>
        <translation>Das Stück ist gegriffen. T lässt es los, Umschalt+T setzt es zurück.</translation>
    </message>
    <message>
        <source>The body is grasped. Press T to release it.</source>
        <translation>Der Körper ist gegriffen. T lässt ihn los.</translation>
    </message>
    <message>
        <source>The piece goes back to its place.</source>
        <translation>Das Stück kommt an seinen Platz zurück.</translation>
    </message>
    <message>
        <source>The tool cannot work here: %1</source>
        <translation>Das Werkzeug kann hier nicht arbeiten: %1</translation>
    </message>
    <message>
        <source>The tool slid behind bone, out of sight, and stopped. Move the cursor, or turn the picture.</source>
        <translation>Das Werkzeug glitt hinter den Knochen, außer Sicht, und hielt an. Den Mauszeiger bewegen oder das Bild drehen.</translation>
    </message>
    <message>
        <source>The burr rubs and hardly cuts at %1 N. Press harder.</source>
        <translation>Die Fräse reibt bei %1 N und schneidet kaum. Stärker drücken.</translation>
    </message>
    <message>
        <source>The burr rubs and hardly cuts at %1 N. Press deeper: PgDn, or the slider Press.</source>
        <translation>Die Fräse reibt bei %1 N und schneidet kaum. Den Druck mit Bild ab erhöhen.</translation>
    </message>
    <message>
        <source>The cut face shows hidden matter, which cannot be reached. Press C until nothing is clipped.</source>
        <translation>Die Schnittfläche zeigt verborgenes Gewebe, das nicht erreichbar ist. C drücken, bis nichts aufgeschnitten ist.</translation>
    </message>
    <message>
        <source>The tool is in the %1, %2 mm deep. Lift it.</source>
        <translation>Das Werkzeug ist zu tief: %1, %2 mm. Anheben.</translation>
    </message>
    <message>
        <source>The tool is in the %1, %2 mm deep. Click away from the entry to withdraw it.</source>
        <translation>Das Werkzeug ist zu tief: %1, %2 mm. Zum Herausziehen neben den Eintritt klicken.</translation>
    </message>
    <message>
        <source>The tool is in the %1, %2 mm deep. Move the cursor away to withdraw it.</source>
        <translation>Das Werkzeug ist zu tief: %1, %2 mm. Zum Herausziehen den Mauszeiger wegbewegen.</translation>
    </message>
    <message>
        <source>The tool is in the %1, %2 mm deep. Release the button to lift it.</source>
        <translation>Das Werkzeug ist zu tief: %1, %2 mm. Zum Anheben die Taste loslassen.</translation>
    </message>
    <message>
        <source>The tool is in the %1, %2 mm deep. Move the cursor away to lift it.</source>
        <translation>Das Werkzeug ist zu tief: %1, %2 mm. Zum Anheben den Mauszeiger wegbewegen.</translation>
    </message>
    <message>
        <source>The force is off: %1. Press F to turn it on again.</source>
        <translation>Die Kraft ist aus: %1. F schaltet sie wieder ein.</translation>
    </message>
    <message>
        <source>The force is off: %1. It returns automatically.</source>
        <translation>Die Kraft ist aus: %1. Sie kommt von selbst wieder.</translation>
    </message>
    <message>
        <source>Depth %1 mm</source>
        <translation>Tiefe %1 mm</translation>
    </message>
    <message>
        <source>%1 mm to the planned target</source>
        <translation>%1 mm bis zum geplanten Ziel</translation>
    </message>
    <message>
        <source>%1 mm beyond the planned target</source>
        <translation>%1 mm hinter dem geplanten Ziel</translation>
    </message>
    <message>
        <source>%1: %2 s so far ...</source>
        <translation>%1: bisher %2 s ...</translation>
    </message>
    <message>
        <source>Preparing the tool</source>
        <translation>Werkzeug wird vorbereitet</translation>
    </message>
    <message>
        <source>The command was refused: %1</source>
        <translation>Der Befehl wurde abgelehnt: %1</translation>
    </message>
    <message>
        <source>The running command was cancelled.</source>
        <translation>Der laufende Befehl wurde abgebrochen.</translation>
    </message>
    <message>
        <source>The pedal does not respond. Connect it again, close this window, and continue the operation.</source>
        <translation>Das Pedal antwortet nicht. Neu anschließen, dieses Fenster schließen und die Operation fortsetzen.</translation>
    </message>
    <message>
        <source>no edge of bone is near. Move the tool to an edge.</source>
        <translation>kein Knochenrand ist nahe. Das Werkzeug an einen Rand führen.</translation>
    </message>
    <message>
        <source>the bone is thicker than the jaws open. Thin it with a burr first.</source>
        <translation>der Knochen ist dicker, als sich das Maul öffnet. Zuerst mit einer Fräse ausdünnen.</translation>
    </message>
    <message>
        <source>the foot has no room at this edge. Return to a burr hole, or tilt the tool.</source>
        <translation>der Fuß hat an diesem Rand keinen Platz. Zu einem Bohrloch zurückkehren oder das Werkzeug kippen.</translation>
    </message>
    <message>
        <source>the foot has no room under the bone. Widen the inner side of the hole with a burr, to about %1</source>
        <translation>der Fuß hat unter dem Knochen keinen Platz. Die Innenseite des Lochs mit einer Fräse auf etwa %1 weiten</translation>
    </message>
    <message>
        <source>the hole is too narrow at its inner end. Widen that end with a burr.</source>
        <translation>das Loch ist innen zu eng. Sein inneres Ende mit einer Fräse weiten.</translation>
    </message>
    <message>
        <source>no burr hole is near. Make one with the perforator first.</source>
        <translation>kein Bohrloch ist nahe. Zuerst eines mit dem Perforator bohren.</translation>
    </message>
    <message>
        <source>the bit is in bone. Start in a burr hole.</source>
        <translation>die Fräse steckt im Knochen. In einem Bohrloch beginnen.</translation>
    </message>
    <message>
        <source>the foot has no room under the bone. Widen the hole to its inner side.</source>
        <translation>der Fuß hat unter dem Knochen keinen Platz. Das Loch bis zur Innenseite weiten.</translation>
    </message>
    <message>
        <source>there is no bone near the bit. Move it to the edge of a burr hole.</source>
        <translation>nahe der Fräse ist kein Knochen. Sie an den Rand eines Bohrlochs führen.</translation>
    </message>
    <message>
        <source>the foot is in bone. Slide it under the lamina first.</source>
        <translation>der Fuß steckt im Knochen. Ihn zuerst unter die Lamina schieben.</translation>
    </message>
    <message>
        <source>a cup is in bone. Move the jaws to a thinner edge, or open them wider.</source>
        <translation>ein Löffel steckt im Knochen. Das Maul an einen dünneren Rand führen oder weiter öffnen.</translation>
    </message>
    <message>
        <source>a catheter without its stylet does not pass the dura. Take the catheter with its stylet.</source>
        <translation>ein Katheter ohne Mandrin dringt nicht durch die Dura. Den Katheter mit Mandrin nehmen.</translation>
    </message>
    <message>
        <source>there is bone within 10 mm ahead of the tip. Aim through the hole, or widen its inner end with a burr.</source>
        <translation>innerhalb von 10 mm vor der Spitze ist Knochen. Durch das Loch zielen oder sein inneres Ende mit einer Fräse weiten.</translation>
    </message>
    <message>
        <source>the catheter meets the edge of the hole. Turn it along the hole, or widen the hole.</source>
        <translation>der Katheter trifft den Rand des Lochs. Ihn in Richtung des Lochs drehen oder das Loch weiten.</translation>
    </message>
    <message>
        <source>there is bone in the way. Drill a burr hole there first.</source>
        <translation>Knochen ist im Weg. Dort zuerst ein Bohrloch anlegen.</translation>
    </message>
    <message>
        <source>Nearest: %1.</source>
        <translation>Am nächsten: %1.</translation>
    </message>
    <message>
        <source>Pin %1.</source>
        <translation>Dorn %1.</translation>
    </message>
    <message>
        <source>%1: click a position. %2</source>
        <translation>%1: eine Position anklicken. %2</translation>
    </message>
    <message>
        <source>%1: click position %2. %3</source>
        <translation>%1: Position %2 anklicken. %3</translation>
    </message>
    <message>
        <source>Esc cancels.</source>
        <translation>Esc bricht ab.</translation>
    </message>
    <message>
        <source>Backspace removes the last one, Esc cancels.</source>
        <translation>Rücktaste entfernt die letzte, Esc bricht ab.</translation>
    </message>
    <message>
        <source>Enter finishes. Esc cancels.</source>
        <translation>Eingabetaste beendet. Esc bricht ab.</translation>
    </message>
    <message>
        <source>Enter finishes. Backspace removes the last one, Esc cancels.</source>
        <translation>Eingabetaste beendet. Rücktaste entfernt die letzte, Esc bricht ab.</translation>
    </message>
    <message>
        <source>Only in the first: %1 mm³; only in the second: %2 mm³</source>
        <translation>Nur im ersten: %1 mm³; nur im zweiten: %2 mm³</translation>
    </message>
    <message>
        <source>Removed in the second: %1 mm³</source>
        <translation>Im zweiten abgetragen: %1 mm³</translation>
    </message>
    <message>
        <source>only in the first</source>
        <translation>nur im ersten</translation>
    </message>
    <message>
        <source>removed in the second</source>
        <translation>im zweiten abgetragen</translation>
    </message>
    <message>
        <source>only in the second</source>
        <translation>nur im zweiten</translation>
    </message>
    <message>
        <source>removed in both</source>
        <translation>in beiden abgetragen</translation>
    </message>
    <message>
        <source>at least %1</source>
        <translation>mindestens %1</translation>
    </message>
    <message>
        <source>at most %1</source>
        <translation>höchstens %1</translation>
    </message>
    <message>
        <source>At least %1 and at most %2 %3 are needed; there are %4.</source>
        <translation>Nötig sind mindestens %1 und höchstens %2 (%3); vorhanden: %4.</translation>
    </message>
    <message>
        <source>At least %1 %2 are needed; there are %3.</source>
        <translation>Nötig sind mindestens %1 (%2); vorhanden: %3.</translation>
    </message>
    <message>
        <source>At least %1 %2 are needed; there is %3.</source>
        <translation>Nötig sind mindestens %1 (%2); vorhanden: %3.</translation>
    </message>
    <message>
        <source>At least %1 %2 is needed; there are %3.</source>
        <translation>Nötig ist mindestens %1 (%2); vorhanden: %3.</translation>
    </message>
    <message>
        <source>At least %1 %2 is needed; the number is unknown.</source>
        <translation>Nötig ist mindestens %1 (%2); die Zahl ist unbekannt.</translation>
    </message>
    <message>
        <source>At least %1 %2 are needed; the number is unknown.</source>
        <translation>Nötig sind mindestens %1 (%2); die Zahl ist unbekannt.</translation>
    </message>
    <message>
        <source>At most %1 %2 are allowed; there are %3.</source>
        <translation>Erlaubt sind höchstens %1 (%2); vorhanden: %3.</translation>
    </message>
    <message>
        <source>At most %1 %2 is allowed; there are %3.</source>
        <translation>Erlaubt ist höchstens %1 (%2); vorhanden: %3.</translation>
    </message>
    <message>
        <source>%1 must be %2; it is %3.</source>
        <translation>%1: verlangt %2; jetzt %3.</translation>
    </message>
    <message>
        <source>%1 must be %2; it is unknown, or outdated by a later change.</source>
        <translation>%1: verlangt %2; der Wert ist unbekannt oder durch eine spätere Änderung veraltet.</translation>
    </message>
    <message>
        <source>at least %1 and at most %2</source>
        <translation>mindestens %1 und höchstens %2</translation>
    </message>
    <message>
        <source>%1 mm³</source>
        <translation>%1 mm³</translation>
    </message>
    <message>
        <source>%1 mm</source>
        <translation>%1 mm</translation>
    </message>
    <message>
        <source>%1 s</source>
        <translation>%1 s</translation>
    </message>
    <message>
        <source>The removed volume</source>
        <translation>Das abgetragene Volumen</translation>
    </message>
    <message>
        <source>The time in this step</source>
        <translation>Die Zeit in diesem Schritt</translation>
    </message>
    <message>
        <source>The distance from %1</source>
        <translation>Der Abstand zu: %1</translation>
    </message>
    <message>
        <source>The number of events %1 in this step</source>
        <translation>Die Zahl der Ereignisse %1 in diesem Schritt</translation>
    </message>
    <message>
        <source>The number of visits of the step %1</source>
        <translation>Die Zahl der Besuche des Schritts %1</translation>
    </message>
    <message>
        <source>Still to do in this step: %1.</source>
        <translation>In diesem Schritt noch zu tun: %1.</translation>
    </message>
    <message>
        <source>measure</source>
        <translation>messen</translation>
    </message>
    <message>
        <source>cut the flap</source>
        <translation>Deckel sägen</translation>
    </message>
    <message>
        <source>judge the flap</source>
        <translation>Deckel beurteilen</translation>
    </message>
    <message>
        <source>judge the laminectomy</source>
        <translation>Laminektomie beurteilen</translation>
    </message>
    <message>
        <source>drill with the perforator until its clutch releases</source>
        <translation>mit dem Perforator bohren, bis die Kupplung auslöst</translation>
    </message>
    <message>
        <source>pass the catheter into a ventricle</source>
        <translation>Katheter in einen Ventrikel führen</translation>
    </message>
    <message>
        <source>make a track with the probe, and draw the probe out</source>
        <translation>mit der Sonde einen Bohrkanal anlegen und die Sonde herausziehen</translation>
    </message>
    <message>
        <source>judge the screws</source>
        <translation>die Schrauben beurteilen</translation>
    </message>
    <message>
        <source>preview the flap</source>
        <translation>eine Vorschau des Deckels anzeigen</translation>
    </message>
    <message>
        <source>free a piece of bone</source>
        <translation>ein Knochenstück lösen</translation>
    </message>
    <message>
        <source>pass the catheter into the brain</source>
        <translation>den Katheter ins Gehirn vorschieben</translation>
    </message>
    <message>
        <source>%1 was refused: the step %2 does not allow the tool in the hand. Choose No tool first.</source>
        <translation>%1 wurde abgelehnt: Der Schritt %2 erlaubt das Werkzeug in der Hand nicht. Wählen Sie zuerst Kein Werkzeug.</translation>
    </message>
    <message>
        <source>make a track with the probe</source>
        <translation>mit der Sonde einen Bohrkanal anlegen</translation>
    </message>
    <message>
        <source>place a screw</source>
        <translation>eine Schraube setzen</translation>
    </message>
    <message>
        <source>take an X-ray</source>
        <translation>ein Röntgenbild aufnehmen</translation>
    </message>
    <message>
        <source>detached pieces</source>
        <translation>gelöste Stücke</translation>
    </message>
    <message>
        <source>detached piece</source>
        <translation>gelöstes Stück</translation>
    </message>
    <message>
        <source>anchors</source>
        <translation>Ankerpunkte</translation>
    </message>
    <message>
        <source>anchor</source>
        <translation>Ankerpunkt</translation>
    </message>
    <message>
        <source>flaps</source>
        <translation>Deckel</translation>
    </message>
    <message>
        <source>flap</source>
        <translation>Deckel</translation>
    </message>
    <message>
        <source>tracks</source>
        <translation>Bohrkanäle</translation>
    </message>
    <message>
        <source>track</source>
        <translation>Bohrkanal</translation>
    </message>
    <message>
        <source>screws</source>
        <translation>Schrauben</translation>
    </message>
    <message>
        <source>screw</source>
        <translation>Schraube</translation>
    </message>
    <message>
        <source>previews</source>
        <translation>Vorschauen</translation>
    </message>
    <message>
        <source>preview</source>
        <translation>Vorschau</translation>
    </message>
    <message>
        <source>Hand %1 holds the %2, which the next step does not allow. Choose another tool, or no tool.</source>
        <translation>Hand %1 hält: %2. Der nächste Schritt erlaubt das nicht. Ein anderes oder kein Werkzeug wählen.</translation>
    </message>
    <message>
        <source>The step &quot;%1&quot; does not allow this %2. It allows: %3.</source>
        <translation>Der Schritt „%1“ erlaubt dies nicht (%2). Erlaubt: %3.</translation>
    </message>
    <message>
        <source>instrument</source>
        <translation>Instrument</translation>
    </message>
    <message>
        <source>command</source>
        <translation>Befehl</translation>
    </message>
    <message>
        <source>nothing</source>
        <translation>nichts</translation>
    </message>
    <message>
        <source>full at %1, none at %2</source>
        <translation>voll bei %1, keine bei %2</translation>
    </message>
    <message>
        <source>reported</source>
        <translation>berichtet</translation>
    </message>
    <message>
        <source>not judged</source>
        <translation>nicht beurteilt</translation>
    </message>
    <message>
        <source>no points: nothing was judged</source>
        <translation>keine Punkte: nichts wurde beurteilt</translation>
    </message>
    <message>
        <source>The tool is led out of restored matter, with at most 3 N.</source>
        <translation>Das Werkzeug wird mit höchstens 3 N aus wiederhergestelltem Gewebe geführt.</translation>
    </message>
    <message>
        <source>The tool is inside matter and touches no surface.</source>
        <translation>Das Werkzeug ist im Gewebe und berührt keine Oberfläche.</translation>
    </message>
    <message>
        <source>The tool touches nothing.</source>
        <translation>Das Werkzeug berührt nichts.</translation>
    </message>
    <message>
        <source>The tool touches %1. The hand is %2 mm beyond the surface. The stiffness is %3 N/mm: the spring force is %4 N.</source>
        <translation>Das Werkzeug berührt: %1. Die Hand ist %2 mm hinter der Oberfläche. Die Steifigkeit ist %3 N/mm: Die Federkraft ist %4 N.</translation>
    </message>
    <message>
        <source>Friction: the tangential force is %1 times the normal force. The static coefficient, above which the tool slips, is %2. The dynamic coefficient is %3.</source>
        <translation>Reibung: Die Tangentialkraft ist das %1-fache der Normalkraft. Der Haftbeiwert, über dem das Werkzeug gleitet, ist %2. Der Gleitbeiwert ist %3.</translation>
    </message>
    <message>
        <source>The surface has no friction.</source>
        <translation>Die Oberfläche hat keine Reibung.</translation>
    </message>
    <message>
        <source>Limits and faults: %1.</source>
        <translation>Grenzen und Fehler: %1.</translation>
    </message>
    <message>
        <source>First steps</source>
        <translation>Erste Schritte</translation>
    </message>
    <message>
        <source>Turn, touch, drill, undo, measure and take an X-ray, in five minutes.</source>
        <translation>Drehen, tasten, bohren, zurücknehmen, messen und röntgen, in fünf Minuten.</translation>
    </message>
    <message>
        <source>Craniotomy</source>
        <translation>Kraniotomie</translation>
    </message>
    <message>
        <source>Plan the outline, drill the holes, cut and lift the flap.</source>
        <translation>Umriss planen, Löcher bohren, Deckel sägen und abheben.</translation>
    </message>
    <message>
        <source>Ventriculostomy</source>
        <translation>Ventrikulostomie</translation>
    </message>
    <message>
        <source>Drill at Kocher&apos;s point and pass a catheter into the ventricle.</source>
        <translation>Am Kocher-Punkt bohren und einen Katheter in den Ventrikel führen.</translation>
    </message>
    <message>
        <source>Laminectomy and screws</source>
        <translation>Laminektomie und Schrauben</translation>
    </message>
    <message>
        <source>Open the canal of L4, probe the pedicles and place screws.</source>
        <translation>Den Kanal von L4 öffnen, die Pedikel sondieren und Schrauben setzen.</translation>
    </message>
    <message>
        <source>Free practice: head</source>
        <translation>Freies Üben: Kopf</translation>
    </message>
    <message>
        <source>All instruments on the built-in skull, without steps.</source>
        <translation>Alle Instrumente am eingebauten Schädel, ohne Schritte.</translation>
    </message>
    <message>
        <source>Free practice: spine</source>
        <translation>Freies Üben: Wirbelsäule</translation>
    </message>
    <message>
        <source>All instruments on the built-in lumbar spine, without steps.</source>
        <translation>Alle Instrumente an der eingebauten Lendenwirbelsäule, ohne Schritte.</translation>
    </message>
    <message>
        <source>Plan the outline</source>
        <translation>Umriss planen</translation>
    </message>
    <message>
        <source>Point at a corner of the flap and press Ctrl+1, which adds an anchor of the outline. Add three or more anchors around the target. Then choose Preview flap in the menu Commands.</source>
        <translation>Auf eine Ecke des Deckels zeigen und Strg+1 drücken; das setzt einen Anker des Umrisses. Drei oder mehr Anker um das Ziel setzen. Dann im Menü Befehle „Vorschau des Deckels“ wählen.</translation>
    </message>
    <message>
        <source>The outline should expose the target with a margin, and keep clear of the venous sinuses.</source>
        <translation>Der Umriss soll das Ziel mit Rand freilegen und Abstand von den venösen Sinus halten.</translation>
    </message>
    <message>
        <source>Drill the burr holes</source>
        <translation>Bohrlöcher bohren</translation>
    </message>
    <message>
        <source>Drill one or more holes on the outline. The perforator stops by its clutch at the inner table; a Press of 4 mm (wheel) drives it.</source>
        <translation>Ein oder mehrere Löcher auf dem Umriss bohren. Der Perforator hält durch seine Kupplung an der Tabula interna; ein Druck von 4 mm (Rad) treibt ihn an.</translation>
    </message>
    <message>
        <source>A hole lets the foot of the craniotome under the bone. Over a sinus the dura tears easily.</source>
        <translation>Durch ein Loch kommt der Fuß des Kraniotoms unter den Knochen. Über einem Sinus reißt die Dura leicht.</translation>
    </message>
    <message>
        <source>Cut the flap</source>
        <translation>Deckel sägen</translation>
    </message>
    <message>
        <source>Join the holes with the craniotome, or cut along the anchors: Cut flap. If the foot of the craniotome has no room, go back and widen the inner end of the hole with the burr. When the flap is free, choose No tool.</source>
        <translation>Die Löcher mit dem Kraniotom verbinden oder entlang der Ankerpunkte sägen: Deckel sägen. Hat der Fuß des Kraniotoms keinen Platz, zurückgehen und das innere Ende des Lochs mit der Fräse weiten. Ist der Deckel frei, „Kein Werkzeug“ wählen.</translation>
    </message>
    <message>
        <source>The foot of the craniotome stays between bone and dura. Bridges of bone keep the flap attached.</source>
        <translation>Der Fuß des Kraniotoms bleibt zwischen Knochen und Dura. Knochenbrücken halten den Deckel fest.</translation>
    </message>
    <message>
        <source>Lift the flap</source>
        <translation>Deckel abheben</translation>
    </message>
    <message>
        <source>Grasp the flap with T, lift it off the dura, and release it with T.</source>
        <translation>Den Deckel mit T greifen, von der Dura abheben und mit T loslassen.</translation>
    </message>
    <message>
        <source>In the operating room the dura is stripped from the flap while it is lifted.</source>
        <translation>Im Operationssaal wird die Dura beim Abheben vom Deckel gelöst.</translation>
    </message>
    <message>
        <source>Inspect the opening</source>
        <translation>Öffnung ansehen</translation>
    </message>
    <message>
        <source>Look at the rim, at the dura and at what the opening exposes. Shift+T puts the flap back in its place.</source>
        <translation>Rand, Dura und das Freigelegte ansehen. Umschalt+T setzt den Deckel zurück.</translation>
    </message>
    <message>
        <source>Hemostasis and tack-up sutures of the dura follow here; they are not simulated.</source>
        <translation>Hier folgen Blutstillung und Durahochnähte; sie werden nicht simuliert.</translation>
    </message>
    <message>
        <source>Evaluate the flap</source>
        <translation>Deckel bewerten</translation>
    </message>
    <message>
        <source>The flap is compared with the target and with the planned outline.</source>
        <translation>Der Deckel wird mit dem Ziel und dem geplanten Umriss verglichen.</translation>
    </message>
    <message>
        <source>Turn the picture</source>
        <translation>Bild drehen</translation>
    </message>
    <message>
        <source>Drag with the right mouse button to turn the picture. Ctrl and the wheel zoom, Shift+A shows the front, 0 shows all. Move the mouse over the skull: the tip under the blue handle follows it. N shows all names; press it again to hide them.</source>
        <translation>Mit der rechten Maustaste ziehen dreht das Bild. Strg und Mausrad zoomen, Umschalt+A zeigt vorn, 0 zeigt alles. Die Maus über den Schädel bewegen: Die Spitze unter dem blauen Griff folgt ihr. N zeigt alle Namen; noch einmal drücken blendet sie aus.</translation>
    </message>
    <message>
        <source>The letters at the border name the patient&apos;s sides: A front, P back, L left, R right, S up, I down. F1 shows all keys.</source>
        <translation>Die Buchstaben am Rand nennen die Seiten des Patienten: A vorn, P hinten, L links, R rechts, S oben, I unten. F1 zeigt alle Tasten.</translation>
    </message>
    <message>
        <source>Drill</source>
        <translation>Bohren</translation>
    </message>
    <message>
        <source>Choose the burr in the panel Tools. Hold the left button on the bone until 5 mm³ are removed, then move the mouse away to see the hole. Ctrl+Z undoes a stroke, Ctrl+Y redoes it.</source>
        <translation>Im Feld Werkzeuge die Fräse wählen. Die linke Taste auf dem Knochen halten, bis 5 mm³ abgetragen sind, dann die Maus wegbewegen, um das Loch zu sehen. Strg+Z nimmt einen Strich zurück, Strg+Y wiederholt ihn.</translation>
    </message>
    <message>
        <source>The blue arrow at the burr is the force on your hand. The wheel sets the depth to which you press.</source>
        <translation>Der blaue Pfeil an der Fräse ist die Kraft auf Ihre Hand. Das Mausrad stellt ein, wie tief Sie drücken.</translation>
    </message>
    <message>
        <source>Measure a distance</source>
        <translation>Abstand messen</translation>
    </message>
    <message>
        <source>Press M, then click two positions on the skull. The step ends with the second click.</source>
        <translation>M drücken, dann zwei Stellen des Schädels anklicken. Der Schritt endet mit dem zweiten Klick.</translation>
    </message>
    <message>
        <source>F6 shows three slices next to the picture. You can also click in them, and one end may be in a slice.</source>
        <translation>F6 zeigt drei Schichten neben dem Bild. Auch in sie kann man klicken, und ein Ende darf in einer Schicht liegen.</translation>
    </message>
    <message>
        <source>Take an X-ray</source>
        <translation>Röntgenbild aufnehmen</translation>
    </message>
    <message>
        <source>Press F7 for the X-ray pane, then press Shoot in it. The step ends with the image.</source>
        <translation>F7 zeigt das Röntgenfeld, darin „Auslösen“ drücken. Der Schritt endet mit dem Bild.</translation>
    </message>
    <message>
        <source>The dose of each exposure is counted; undo does not subtract it. F5 shows the picture alone again.</source>
        <translation>Die Dosis jeder Aufnahme zählt; Zurücknehmen zieht sie nicht ab. F5 zeigt wieder nur das Bild.</translation>
    </message>
    <message>
        <source>Make a burr hole</source>
        <translation>Bohrloch anlegen</translation>
    </message>
    <message>
        <source>Choose the perforator and move it to the top of the head. Set Press to 4 mm with the wheel, and hold the left button until the clutch stops the drill at the inner table.</source>
        <translation>Den Perforator wählen und oben auf den Kopf führen. Den Druck mit dem Rad auf 4 mm stellen und die linke Taste halten, bis die Kupplung den Bohrer an der Tabula interna anhält.</translation>
    </message>
    <message>
        <source>The clutch stops the perforator when its inner drill leaves the bone. The dura below the bone remains intact. Slices and picture show the hole.</source>
        <translation>Die Kupplung hält den Perforator an, sobald der innere Bohrer den Knochen verlässt. Die Dura darunter bleibt heil. Schichten und Bild zeigen das Loch.</translation>
    </message>
    <message>
        <source>Finished</source>
        <translation>Fertig</translation>
    </message>
    <message>
        <source>Close the window and choose an operation. Its steps, hints and score work as these did.</source>
        <translation>Das Fenster schließen und eine Operation wählen. Schritte, Hinweise und Bewertung arbeiten dort ebenso.</translation>
    </message>
    <message>
        <source>Laminectomy with pedicle screws</source>
        <translation>Laminektomie mit Pedikelschrauben</translation>
    </message>
    <message>
        <source>Remove bone</source>
        <translation>Knochen abtragen</translation>
    </message>
    <message>
        <source>Thin the lamina with the burr, and open the canal with the Kerrison: choose Rongeur, and Kerrison as its kind.</source>
        <translation>Die Lamina mit der Fräse ausdünnen und den Kanal mit der Kerrison-Stanze öffnen: Instrument Rongeur, Art Kerrison.</translation>
    </message>
    <message>
        <source>The dural sac lies under the lamina. Facets and pars keep the spine stable.</source>
        <translation>Unter der Lamina liegt der Durasack. Facetten und Pars halten die Wirbelsäule stabil.</translation>
    </message>
    <message>
        <source>Probe the pedicles</source>
        <translation>Pedikel sondieren</translation>
    </message>
    <message>
        <source>Push the probe through the pedicle into the body of the vertebra.</source>
        <translation>Die Sonde durch den Pedikel in den Wirbelkörper schieben.</translation>
    </message>
    <message>
        <source>A loss of resistance before the planned depth is a breach.</source>
        <translation>Ein Widerstandsverlust vor der geplanten Tiefe ist ein Durchbruch.</translation>
    </message>
    <message>
        <source>Place the screws</source>
        <translation>Schrauben setzen</translation>
    </message>
    <message>
        <source>Choose Place screw in the menu Commands, with diameter and length, to place a screw in a track.</source>
        <translation>Im Menü Befehle „Schraube setzen“ wählen, mit Durchmesser und Länge, um eine Schraube in einen Bohrkanal zu setzen.</translation>
    </message>
    <message>
        <source>A screw should fill most of the pedicle without breaching it.</source>
        <translation>Eine Schraube soll den Pedikel weitgehend ausfüllen, ohne ihn zu durchbrechen.</translation>
    </message>
    <message>
        <source>Evaluate canal and screws</source>
        <translation>Kanal und Schrauben bewerten</translation>
    </message>
    <message>
        <source>Choose Judge screw for each screw, and Judge laminectomy for the canal, in the menu Commands.</source>
        <translation>Im Menü Befehle „Schraube beurteilen“ für jede Schraube und „Laminektomie beurteilen“ für den Kanal wählen.</translation>
    </message>
    <message>
        <source>The operation is complete</source>
        <translation>Die Operation ist abgeschlossen</translation>
    </message>
    <message>
        <source>Mark the entry</source>
        <translation>Eintritt markieren</translation>
    </message>
    <message>
        <source>Measure with a tape from the nasion: 11 cm back, and 3 cm to the side. This is Kocher&apos;s point.</source>
        <translation>Mit dem Maßband vom Nasion messen: 11 cm nach hinten und 3 cm zur Seite. Dort ist der Kocher-Punkt.</translation>
    </message>
    <message>
        <source>Kocher&apos;s point lies in front of the motor cortex and lateral to the sagittal sinus.</source>
        <translation>Der Kocher-Punkt liegt vor der motorischen Rinde und seitlich des Sinus sagittalis.</translation>
    </message>
    <message>
        <source>Drill the burr hole</source>
        <translation>Bohrloch bohren</translation>
    </message>
    <message>
        <source>Drill through both tables of the skull at the marked entry, and stop at the dura: the catheter punctures it.</source>
        <translation>Bohren Sie am markierten Eintrittspunkt durch beide Tafeln des Schädels, und halten Sie an der Dura an: Der Katheter durchsticht sie.</translation>
    </message>
    <message>
        <source>The hole must leave room for the direction of the catheter.</source>
        <translation>Das Loch muss der Richtung des Katheters Raum lassen.</translation>
    </message>
    <message>
        <source>Pass the catheter</source>
        <translation>Katheter vorschieben</translation>
    </message>
    <message>
        <source>Push the catheter toward the foramen of Monro until it pops through the wall of the ventricle.</source>
        <translation>Den Katheter auf das Foramen Monroi zu schieben, bis er spürbar durch die Ventrikelwand dringt.</translation>
    </message>
    <message>
        <source>No more than three passages: each one crosses brain.</source>
        <translation>Höchstens drei Versuche: Jeder kreuzt Hirngewebe.</translation>
    </message>
    <message>
        <source>Evaluate the catheter</source>
        <translation>Katheter bewerten</translation>
    </message>
    <message>
        <source>Entry, tip and depth are compared with the planned trajectory whose entry is nearest.</source>
        <translation>Eintritt, Spitze und Tiefe werden mit der geplanten Trajektorie verglichen, deren Eintritt am nächsten liegt.</translation>
    </message>
    <message>
        <source>%1: %2</source>
        <translation>%1: %2</translation>
    </message>
    <message>
        <source>Burr</source>
        <translation>Fräse</translation>
    </message>
    <message>
        <source>Perforator</source>
        <translation>Perforator</translation>
    </message>
    <message>
        <source>Craniotome</source>
        <translation>Kraniotom</translation>
    </message>
    <message>
        <source>Rongeur</source>
        <translation>Rongeur</translation>
    </message>
    <message>
        <source>Probe</source>
        <translation>Sonde</translation>
    </message>
    <message>
        <source>Catheter</source>
        <translation>Katheter</translation>
    </message>
    <message>
        <source>burr</source>
        <translation>Fräse</translation>
    </message>
    <message>
        <source>perforator</source>
        <translation>Perforator</translation>
    </message>
    <message>
        <source>craniotome</source>
        <translation>Kraniotom</translation>
    </message>
    <message>
        <source>rongeur</source>
        <translation>Rongeur</translation>
    </message>
    <message>
        <source>probe</source>
        <translation>Sonde</translation>
    </message>
    <message>
        <source>catheter</source>
        <translation>Katheter</translation>
    </message>
    <message>
        <source>Shoot</source>
        <translation>Röntgenbild aufnehmen</translation>
    </message>
    <message>
        <source>Add anchor</source>
        <translation>Ankerpunkt setzen</translation>
    </message>
    <message>
        <source>C arm</source>
        <translation>C-Bogen einstellen</translation>
    </message>
    <message>
        <source>Clear anchors</source>
        <translation>Ankerpunkte löschen</translation>
    </message>
    <message>
        <source>Clear measures</source>
        <translation>Messungen löschen</translation>
    </message>
    <message>
        <source>Clear pins</source>
        <translation>Dorne löschen</translation>
    </message>
    <message>
        <source>Cut flap</source>
        <translation>Deckel sägen</translation>
    </message>
    <message>
        <source>Fit clamp</source>
        <translation>Klemme anpassen</translation>
    </message>
    <message>
        <source>Grey window</source>
        <translation>Fensterung einstellen</translation>
    </message>
    <message>
        <source>Judge catheter</source>
        <translation>Katheter beurteilen</translation>
    </message>
    <message>
        <source>Judge flap</source>
        <translation>Deckel beurteilen</translation>
    </message>
    <message>
        <source>Judge laminectomy</source>
        <translation>Laminektomie beurteilen</translation>
    </message>
    <message>
        <source>Judge screw</source>
        <translation>Schraube beurteilen</translation>
    </message>
    <message>
        <source>Leave catheter</source>
        <translation>Katheter belassen</translation>
    </message>
    <message>
        <source>Look at</source>
        <translation>Position ansehen</translation>
    </message>
    <message>
        <source>Measure</source>
        <translation>Messen</translation>
    </message>
    <message>
        <source>Measure section</source>
        <translation>Schnitt messen</translation>
    </message>
    <message>
        <source>Move anchor</source>
        <translation>Ankerpunkt verschieben</translation>
    </message>
    <message>
        <source>Move pin</source>
        <translation>Dorn verschieben</translation>
    </message>
    <message>
        <source>Place pin</source>
        <translation>Dorn setzen</translation>
    </message>
    <message>
        <source>Place screw</source>
        <translation>Schraube setzen</translation>
    </message>
    <message>
        <source>Preview flap</source>
        <translation>Vorschau des Deckels</translation>
    </message>
    <message>
        <source>Remove anchor</source>
        <translation>Ankerpunkt entfernen</translation>
    </message>
    <message>
        <source>Remove screw</source>
        <translation>Schraube entfernen</translation>
    </message>
    <message>
        <source>Section plane</source>
        <translation>Schnittebene einstellen</translation>
    </message>
    <message>
        <source>Set clamp</source>
        <translation>Klemme wählen</translation>
    </message>
    <message>
        <source>Set posture</source>
        <translation>Lagerung einstellen</translation>
    </message>
    <message>
        <source>cut flap</source>
        <translation>Deckel sägen</translation>
    </message>
    <message>
        <source>preview flap</source>
        <translation>Vorschau des Deckels</translation>
    </message>
    <message>
        <source>judge flap</source>
        <translation>Deckel beurteilen</translation>
    </message>
    <message>
        <source>judge laminectomy</source>
        <translation>Laminektomie beurteilen</translation>
    </message>
    <message>
        <source>judge screw</source>
        <translation>Schraube beurteilen</translation>
    </message>
    <message>
        <source>judge catheter</source>
        <translation>Katheter beurteilen</translation>
    </message>
    <message>
        <source>measure section</source>
        <translation>Schnitt messen</translation>
    </message>
    <message>
        <source>fit clamp</source>
        <translation>Klemme anpassen</translation>
    </message>
    <message>
        <source>place screw</source>
        <translation>Schraube setzen</translation>
    </message>
    <message>
        <source>leave catheter</source>
        <translation>Katheter belassen</translation>
    </message>
    <message>
        <source>shoot</source>
        <translation>Röntgen</translation>
    </message>
    <message>
        <source>add anchor</source>
        <translation>Ankerpunkt setzen</translation>
    </message>
    <message>
        <source>go to step</source>
        <translation>zum Schritt gehen</translation>
    </message>
    <message>
        <source>undo</source>
        <translation>zurücknehmen</translation>
    </message>
    <message>
        <source>redo</source>
        <translation>wiederholen</translation>
    </message>
    <message>
        <source>remove instrument</source>
        <translation>Instrument ablegen</translation>
    </message>
    <message>
        <source>take instrument</source>
        <translation>Instrument nehmen</translation>
    </message>
    <message>
        <source>Anchors</source>
        <translation>Ankerpunkte</translation>
    </message>
    <message>
        <source>At</source>
        <translation>Position</translation>
    </message>
    <message>
        <source>Body</source>
        <translation>Körper</translation>
    </message>
    <message>
        <source>Canal</source>
        <translation>Kanal</translation>
    </message>
    <message>
        <source>Current</source>
        <translation>Röhrenstrom</translation>
    </message>
    <message>
        <source>Diameter</source>
        <translation>Durchmesser</translation>
    </message>
    <message>
        <source>Distance</source>
        <translation>Entfernung</translation>
    </message>
    <message>
        <source>Entry</source>
        <translation>Eintritt</translation>
    </message>
    <message>
        <source>Foot</source>
        <translation>Fuß</translation>
    </message>
    <message>
        <source>Forced</source>
        <translation>Erzwungen</translation>
    </message>
    <message>
        <source>Guide</source>
        <translation>Führung</translation>
    </message>
    <message>
        <source>Height</source>
        <translation>Höhe</translation>
    </message>
    <message>
        <source>Isocentre</source>
        <translation>Isozentrum</translation>
    </message>
    <message>
        <source>Item</source>
        <translation>Form</translation>
    </message>
    <message>
        <source>Kind</source>
        <translation>Art</translation>
    </message>
    <message>
        <source>Least opening</source>
        <translation>Kleinste Öffnung</translation>
    </message>
    <message>
        <source>Length</source>
        <translation>Länge</translation>
    </message>
    <message>
        <source>Level</source>
        <translation>Mitte</translation>
    </message>
    <message>
        <source>Model</source>
        <translation>Modell</translation>
    </message>
    <message>
        <source>Most opening</source>
        <translation>Größte Öffnung</translation>
    </message>
    <message>
        <source>Normal</source>
        <translation>Normale</translation>
    </message>
    <message>
        <source>Number</source>
        <translation>Nummer</translation>
    </message>
    <message>
        <source>Opening</source>
        <translation>Öffnung</translation>
    </message>
    <message>
        <source>Outline</source>
        <translation>Umriss</translation>
    </message>
    <message>
        <source>Outside</source>
        <translation>Außen</translation>
    </message>
    <message>
        <source>Planned</source>
        <translation>Geplant</translation>
    </message>
    <message>
        <source>Radius</source>
        <translation>Radius</translation>
    </message>
    <message>
        <source>Resistance</source>
        <translation>Widerstand</translation>
    </message>
    <message>
        <source>Rocker width</source>
        <translation>Breite der Wippe</translation>
    </message>
    <message>
        <source>Shape</source>
        <translation>Form</translation>
    </message>
    <message>
        <source>Site</source>
        <translation>Stelle</translation>
    </message>
    <message>
        <source>Stylet</source>
        <translation>Mandrin</translation>
    </message>
    <message>
        <source>Swing</source>
        <translation>Ausschlag</translation>
    </message>
    <message>
        <source>Target</source>
        <translation>Ziel</translation>
    </message>
    <message>
        <source>Time</source>
        <translation>Zeit</translation>
    </message>
    <message>
        <source>Track</source>
        <translation>Bohrkanal</translation>
    </message>
    <message>
        <source>Trajectory</source>
        <translation>Trajektorie</translation>
    </message>
    <message>
        <source>Trajectory share</source>
        <translation>Anteil der Trajektorie</translation>
    </message>
    <message>
        <source>Turn</source>
        <translation>Drehung</translation>
    </message>
    <message>
        <source>Up</source>
        <translation>Oben</translation>
    </message>
    <message>
        <source>Voltage</source>
        <translation>Spannung</translation>
    </message>
    <message>
        <source>Width</source>
        <translation>Breite</translation>
    </message>
    <message>
        <source>Seconds</source>
        <translation>Sekunden</translation>
    </message>
    <message>
        <source>Pixel</source>
        <translation>Pixel</translation>
    </message>
    <message>
        <source>Air space to saw through</source>
        <translation>Durchsägter Hohlraum</translation>
    </message>
    <message>
        <source>Bit diameter</source>
        <translation>Durchmesser der Fräse</translation>
    </message>
    <message>
        <source>Bit length</source>
        <translation>Länge der Fräse</translation>
    </message>
    <message>
        <source>Centre</source>
        <translation>Mitte</translation>
    </message>
    <message>
        <source>Clip the view at the plane</source>
        <translation>Ansicht an der Ebene aufschneiden</translation>
    </message>
    <message>
        <source>Closing time</source>
        <translation>Schließzeit</translation>
    </message>
    <message>
        <source>Columns</source>
        <translation>Spalten</translation>
    </message>
    <message>
        <source>Cranial (+) or caudal (-)</source>
        <translation>kranial (+) oder kaudal (-)</translation>
    </message>
    <message>
        <source>Cuts what it sweeps</source>
        <translation>Trägt alles Überstrichene ab</translation>
    </message>
    <message>
        <source>Cutting length</source>
        <translation>Schneidenlänge</translation>
    </message>
    <message>
        <source>Depth where the saw lines meet</source>
        <translation>Tiefe des Schnittpunkts der Sägelinien</translation>
    </message>
    <message>
        <source>Engaging force</source>
        <translation>Eingriffskraft</translation>
    </message>
    <message>
        <source>Fastest feed</source>
        <translation>Höchster Vorschub</translation>
    </message>
    <message>
        <source>Feed per newton</source>
        <translation>Vorschub je Newton</translation>
    </message>
    <message>
        <source>Fixed removal rate</source>
        <translation>Feste Abtragsrate</translation>
    </message>
    <message>
        <source>Foot diameter</source>
        <translation>Durchmesser des Fußes</translation>
    </message>
    <message>
        <source>Gap to cross</source>
        <translation>Überbrückte Lücke</translation>
    </message>
    <message>
        <source>Inner diameter</source>
        <translation>Innendurchmesser</translation>
    </message>
    <message>
        <source>Jaw opening</source>
        <translation>Maulöffnung</translation>
    </message>
    <message>
        <source>Jaw thickness</source>
        <translation>Maulstärke</translation>
    </message>
    <message>
        <source>Jaw width</source>
        <translation>Maulbreite</translation>
    </message>
    <message>
        <source>LAO (+) or RAO (-)</source>
        <translation>LAO (+) oder RAO (-)</translation>
    </message>
    <message>
        <source>Largest bite</source>
        <translation>Größter Biss</translation>
    </message>
    <message>
        <source>Lead of the inner drill</source>
        <translation>Vorlauf des inneren Bohrers</translation>
    </message>
    <message>
        <source>Open height</source>
        <translation>Offene Höhe</translation>
    </message>
    <message>
        <source>Open width</source>
        <translation>Offene Breite</translation>
    </message>
    <message>
        <source>Outer diameter</source>
        <translation>Außendurchmesser</translation>
    </message>
    <message>
        <source>Pieces that stay</source>
        <translation>Stücke, die bleiben</translation>
    </message>
    <message>
        <source>Position in the canal</source>
        <translation>Position im Kanal</translation>
    </message>
    <message>
        <source>Position on the flap</source>
        <translation>Position auf dem Deckel</translation>
    </message>
    <message>
        <source>Rows</source>
        <translation>Zeilen</translation>
    </message>
    <message>
        <source>Saw width</source>
        <translation>Sägebreite</translation>
    </message>
    <message>
        <source>Shaft that touches</source>
        <translation>Tastender Schaft</translation>
    </message>
    <message>
        <source>Shape that is the skull</source>
        <translation>Form, die der Schädel ist</translation>
    </message>
    <message>
        <source>Smallest piece</source>
        <translation>Kleinstes Stück</translation>
    </message>
    <message>
        <source>Smoothing of the rim</source>
        <translation>Glättung des Rands</translation>
    </message>
    <message>
        <source>Source to detector</source>
        <translation>Quelle bis Detektor</translation>
    </message>
    <message>
        <source>Source to patient</source>
        <translation>Quelle bis Patient</translation>
    </message>
    <message>
        <source>Speed</source>
        <translation>Drehzahl</translation>
    </message>
    <message>
        <source>Thickest calvaria</source>
        <translation>Dickste Kalotte</translation>
    </message>
    <message>
        <source>Tightest curve</source>
        <translation>Engste Kurve</translation>
    </message>
    <message>
        <source>Touches with the whole burr</source>
        <translation>Tastet mit der ganzen Fräse</translation>
    </message>
    <message>
        <source>Type</source>
        <translation>Typ</translation>
    </message>
    <message>
        <source>Without irrigation</source>
        <translation>Ohne Spülung</translation>
    </message>
    <message>
        <source>or a position in its canal</source>
        <translation>oder eine Position in seinem Kanal</translation>
    </message>
    <message>
        <source>Anchors; without anchors, the only outline</source>
        <translation>Gesetzte Ankerpunkte oder der einzige Umriss</translation>
    </message>
    <message>
        <source>First of the plan</source>
        <translation>Erste des Plans</translation>
    </message>
    <message>
        <source>Nearest outline</source>
        <translation>Nächster Umriss</translation>
    </message>
    <message>
        <source>Nearest planned trajectory</source>
        <translation>Nächste Ventrikulostomie</translation>
    </message>
    <message>
        <source>Target of the plan</source>
        <translation>Ziel des Plans</translation>
    </message>
    <message>
        <source>That of the screw</source>
        <translation>Der der Schraube</translation>
    </message>
    <message>
        <source>The last screw</source>
        <translation>Die letzte Schraube</translation>
    </message>
    <message>
        <source>The last track</source>
        <translation>Der letzte Bohrkanal</translation>
    </message>
    <message>
        <source>The one that was cut</source>
        <translation>Der bearbeitete</translation>
    </message>
    <message>
        <source>Standard</source>
        <translation>Standard</translation>
    </message>
    <message>
        <source>Small</source>
        <translation>Klein</translation>
    </message>
    <message>
        <source>Angle</source>
        <translation>Winkel</translation>
    </message>
    <message>
        <source>Kerrison</source>
        <translation>Kerrison</translation>
    </message>
    <message>
        <source>Diamond</source>
        <translation>Diamant</translation>
    </message>
    <message>
        <source>Region</source>
        <translation>Bereich</translation>
    </message>
    <message>
        <source>Sphere</source>
        <translation>Kugel</translation>
    </message>
    <message>
        <source>Walls</source>
        <translation>Wände</translation>
    </message>
    <message>
        <source>Line</source>
        <translation>Linie</translation>
    </message>
    <message>
        <source>Match head</source>
        <translation>Streichholzkopf</translation>
    </message>
    <message>
        <source>Barrel</source>
        <translation>Walze</translation>
    </message>
    <message>
        <source>Tape</source>
        <translation>Maßband</translation>
    </message>
    <message>
        <source>Cutting</source>
        <translation>Schneidend</translation>
    </message>
    <message>
        <source>Ruler</source>
        <translation>Lineal</translation>
    </message>
    <message>
        <source>Cylinder</source>
        <translation>Zylinder</translation>
    </message>
    <message>
        <source>Patch</source>
        <translation>Fläche</translation>
    </message>
    <message>
        <source>Part</source>
        <translation>Teil</translation>
    </message>
    <message>
        <source>Area</source>
        <translation>Fläche</translation>
    </message>
    <message>
        <source>Values within 5 mm</source>
        <translation>Werte im Umkreis von 5 mm</translation>
    </message>
    <message>
        <source>degrees</source>
        <translation>Grad</translation>
    </message>
    <message>
        <source>1/min</source>
        <translation>1/min</translation>
    </message>
    <message>
        <source>+ with the detector toward the head (cranial)</source>
        <translation>+ mit dem Detektor kopfwärts (kranial)</translation>
    </message>
    <message>
        <source>0: detector in front of the patient; + toward the left (LAO)</source>
        <translation>0: Detektor vor dem Patienten; + nach links (LAO)</translation>
    </message>
    <message>
        <source>a cutting burr has teeth, a diamond one grains</source>
        <translation>eine schneidende Fräse hat Zähne, eine Diamantfräse Körner</translation>
    </message>
    <message>
        <source>a force that holds the probe on a line, or the track&apos;s walls</source>
        <translation>eine Kraft, die die Sonde auf einer Linie hält, oder die Wände des Bohrkanals</translation>
    </message>
    <message>
        <source>two points, before the bone and at the tip; empty: the newest catheter</source>
        <translation>ein Punkt vor dem Knochen und die Spitze; ohne Punkte der neueste Katheter</translation>
    </message>
    <message>
        <source>a stylet is in the catheter; without it the catheter does not pass the dura</source>
        <translation>ein Mandrin ist im Katheter; ohne ihn dringt er nicht durch die Dura</translation>
    </message>
    <message>
        <source>allows a tip far in front of the bone</source>
        <translation>erlaubt eine Spitze weit vor dem Knochen</translation>
    </message>
    <message>
        <source>centre of the window</source>
        <translation>Mitte des Fensters</translation>
    </message>
    <message>
        <source>contact force above which the clutch engages</source>
        <translation>Kontaktkraft, über der die Kupplung greift</translation>
    </message>
    <message>
        <source>diameter of the bit</source>
        <translation>Durchmesser der Fräse</translation>
    </message>
    <message>
        <source>diameter of the catheter</source>
        <translation>Durchmesser des Katheters</translation>
    </message>
    <message>
        <source>diameter of the foot</source>
        <translation>Durchmesser des Fußes</translation>
    </message>
    <message>
        <source>diameter of the inner drill, which has a round end</source>
        <translation>Durchmesser des inneren Bohrers mit rundem Ende</translation>
    </message>
    <message>
        <source>diameter of the outer drill</source>
        <translation>Durchmesser des äußeren Bohrers</translation>
    </message>
    <message>
        <source>diameter of the track</source>
        <translation>Durchmesser des Bohrkanals</translation>
    </message>
    <message>
        <source>direction away from the floor, in the frame of the head</source>
        <translation>Richtung vom Boden weg, im Bezugssystem des Kopfes</translation>
    </message>
    <message>
        <source>distance between the tips of the pair; 0: that of the model</source>
        <translation>Abstand der Spitzen des Paars; 0: der des Modells</translation>
    </message>
    <message>
        <source>distance by which the inner drill is ahead</source>
        <translation>Strecke, um die der innere Bohrer vorläuft</translation>
    </message>
    <message>
        <source>distance from source to detector</source>
        <translation>Abstand der Quelle vom Detektor</translation>
    </message>
    <message>
        <source>distance from source to isocentre</source>
        <translation>Abstand der Quelle vom Isozentrum</translation>
    </message>
    <message>
        <source>distance from the outline&apos;s centre to the point where all lines of the saw meet</source>
        <translation>Abstand von der Mitte des Umrisses zum Punkt, in dem sich alle Sägelinien treffen</translation>
    </message>
    <message>
        <source>duration of its motion</source>
        <translation>Dauer der Bewegung</translation>
    </message>
    <message>
        <source>exposure time</source>
        <translation>Belichtungszeit</translation>
    </message>
    <message>
        <source>fastest motion through matter</source>
        <translation>schnellste Bewegung durch Gewebe</translation>
    </message>
    <message>
        <source>feed per newton of contact force</source>
        <translation>Vorschub je Newton Kontaktkraft</translation>
    </message>
    <message>
        <source>force along the shaft that extends the track</source>
        <translation>Kraft längs des Schafts, die den Bohrkanal verlängert</translation>
    </message>
    <message>
        <source>gap of the open jaws</source>
        <translation>Weite des offenen Mauls</translation>
    </message>
    <message>
        <source>hide everything in front of the plane</source>
        <translation>alles vor der Ebene ausblenden</translation>
    </message>
    <message>
        <source>label of the vertebra; without it that of the screw</source>
        <translation>Label des Wirbels; ohne: das der Schraube</translation>
    </message>
    <message>
        <source>label of the vertebra; without it the one that lost the most bone</source>
        <translation>Label des Wirbels; ohne: der, der am meisten Knochen verlor</translation>
    </message>
    <message>
        <source>label that the flap should expose; without it the first target of the plan</source>
        <translation>Label, das der Deckel freilegen soll; ohne: das erste Ziel des Plans</translation>
    </message>
    <message>
        <source>largest diameter</source>
        <translation>größter Durchmesser</translation>
    </message>
    <message>
        <source>largest opening of the clamp; 0: that of the model</source>
        <translation>größte Öffnung der Klemme; 0: die des Modells</translation>
    </message>
    <message>
        <source>largest swing of the rocker; below 0: that of the model</source>
        <translation>größter Ausschlag der Wippe; unter 0: der des Modells</translation>
    </message>
    <message>
        <source>largest thickness of the calvaria</source>
        <translation>größte Dicke der Kalotte</translation>
    </message>
    <message>
        <source>largest volume of a bite</source>
        <translation>größtes Volumen eines Bisses</translation>
    </message>
    <message>
        <source>length below the head</source>
        <translation>Länge unter dem Kopf</translation>
    </message>
    <message>
        <source>length from the tip to the hub</source>
        <translation>Länge von der Spitze bis zum Ansatz</translation>
    </message>
    <message>
        <source>length of the bit</source>
        <translation>Länge der Fräse</translation>
    </message>
    <message>
        <source>length of the cutting part; 0: usual for the shape</source>
        <translation>Länge des schneidenden Teils; 0: üblich für die Form</translation>
    </message>
    <message>
        <source>length of the shaft that also touches, if round is set</source>
        <translation>Länge des mittastenden Schafts, wenn mit der ganzen Fräse getastet wird</translation>
    </message>
    <message>
        <source>length that remains outside the outermost layer</source>
        <translation>Länge, die außerhalb der äußersten Schicht bleibt</translation>
    </message>
    <message>
        <source>longest track</source>
        <translation>längster Bohrkanal</translation>
    </message>
    <message>
        <source>normal of the plane</source>
        <translation>Normale der Ebene</translation>
    </message>
    <message>
        <source>number of the anchor, starting at 1</source>
        <translation>Nummer des Ankerpunkts, ab 1</translation>
    </message>
    <message>
        <source>number of the anchor; 0: the last one</source>
        <translation>Nummer des Ankerpunkts; 0: der letzte</translation>
    </message>
    <message>
        <source>number of the pin; 1 is the single pin</source>
        <translation>Nummer des Dorns; 1 ist der einzelne</translation>
    </message>
    <message>
        <source>number of the track; 0: the last</source>
        <translation>Nummer des Bohrkanals; 0: der letzte</translation>
    </message>
    <message>
        <source>numbers of pieces that stay; 1 is the largest piece</source>
        <translation>Nummern der Stücke, die bleiben; 1 ist das größte</translation>
    </message>
    <message>
        <source>open height of the detector; 0: all</source>
        <translation>offene Höhe des Detektors; 0: ganz</translation>
    </message>
    <message>
        <source>open width of the detector; 0: all</source>
        <translation>offene Breite des Detektors; 0: ganz</translation>
    </message>
    <message>
        <source>outer diameter</source>
        <translation>Außendurchmesser</translation>
    </message>
    <message>
        <source>outline of the plan, instead of anchors</source>
        <translation>Umriss des Plans anstelle von Ankerpunkten</translation>
    </message>
    <message>
        <source>outline of the plan; without it the nearest one</source>
        <translation>Umriss des Plans; ohne: der nächste</translation>
    </message>
    <message>
        <source>outline or trajectory of the approach; without it the first</source>
        <translation>Umriss oder Trajektorie des Zugangs; ohne: der erste</translation>
    </message>
    <message>
        <source>pixel size of the detector</source>
        <translation>Pixelgröße des Detektors</translation>
    </message>
    <message>
        <source>point of the plane, world frame</source>
        <translation>Punkt der Ebene, Weltkoordinaten</translation>
    </message>
    <message>
        <source>points of a planned outline, in order, instead of its name</source>
        <translation>Punkte eines geplanten Umrisses, der Reihe nach, anstelle seines Namens</translation>
    </message>
    <message>
        <source>position at which it enters, instead of a track</source>
        <translation>Eintrittsstelle, anstelle eines Bohrkanals</translation>
    </message>
    <message>
        <source>position in its canal, at the height of the lamina</source>
        <translation>Position in seinem Kanal, auf Höhe der Lamina</translation>
    </message>
    <message>
        <source>position in the canal, at the height of the lamina; required in a scan without labels</source>
        <translation>Position im Kanal, auf Höhe der Lamina; nötig in einer Aufnahme ohne Labels</translation>
    </message>
    <message>
        <source>position of the slices, world frame</source>
        <translation>Position der Schichten, Weltkoordinaten</translation>
    </message>
    <message>
        <source>position on the flap; if empty, bone near the outline&apos;s centre</source>
        <translation>Position auf dem Deckel; leer: Knochen nahe der Mitte des Umrisses</translation>
    </message>
    <message>
        <source>position on the head</source>
        <translation>Position auf dem Kopf</translation>
    </message>
    <message>
        <source>position on the skull</source>
        <translation>Position auf dem Schädel</translation>
    </message>
    <message>
        <source>position toward which it points</source>
        <translation>Position, auf die sie zeigt</translation>
    </message>
    <message>
        <source>positions in the world; the second of an angle is its vertex</source>
        <translation>Positionen in Weltkoordinaten; die zweite eines Winkels ist sein Scheitel</translation>
    </message>
    <message>
        <source>positions on the skull, in order around the outline</source>
        <translation>Positionen auf dem Schädel, der Reihe nach um den Umriss</translation>
    </message>
    <message>
        <source>radius of a region, reach of a part</source>
        <translation>Radius eines Bereichs, Reichweite eines Teils</translation>
    </message>
    <message>
        <source>radius of the tightest curve</source>
        <translation>Radius der engsten Kurve</translation>
    </message>
    <message>
        <source>rate in contact at any force; 0: by force, speed and bone</source>
        <translation>Rate bei Kontakt mit beliebiger Kraft; 0: nach Kraft, Drehzahl und Knochen</translation>
    </message>
    <message>
        <source>removes all that it sweeps, touched or not</source>
        <translation>trägt alles Überstrichene ab, berührt oder nicht</translation>
    </message>
    <message>
        <source>shape of the bone</source>
        <translation>Form des Knochens</translation>
    </message>
    <message>
        <source>shape of the cutting part</source>
        <translation>Form des schneidenden Teils</translation>
    </message>
    <message>
        <source>index of the touched shape that is the skull</source>
        <translation>Index der getasteten Form, die der Schädel ist</translation>
    </message>
    <message>
        <source>shape that is measured</source>
        <translation>Form, die gemessen wird</translation>
    </message>
    <message>
        <source>share of the trajectory in the score</source>
        <translation>Anteil der Trajektorie an der Bewertung</translation>
    </message>
    <message>
        <source>sigma of a Gaussian over the rim</source>
        <translation>Sigma eines Gauß-Filters über dem Rand</translation>
    </message>
    <message>
        <source>size of the clamp</source>
        <translation>Größe der Klemme</translation>
    </message>
    <message>
        <source>smaller pieces become debris, except the piece at the position on the flap</source>
        <translation>kleinere Stücke werden Abrieb, außer dem an der Position auf dem Deckel</translation>
    </message>
    <message>
        <source>smallest opening of the clamp; 0: that of the model</source>
        <translation>kleinste Öffnung der Klemme; 0: die des Modells</translation>
    </message>
    <message>
        <source>speed of the spindle</source>
        <translation>Drehzahl der Spindel</translation>
    </message>
    <message>
        <source>the whole burr touches, not a point</source>
        <translation>die ganze Fräse tastet, nicht ein Punkt</translation>
    </message>
    <message>
        <source>thickness of each jaw</source>
        <translation>Dicke jeder Backe</translation>
    </message>
    <message>
        <source>time in which the jaws close while the button is held; devices with an analogue squeeze do not use it</source>
        <translation>Zeit, in der sich das Maul bei gehaltener Taste schließt; Geräte mit analogem Griff verwenden sie nicht</translation>
    </message>
    <message>
        <source>toward the viewer</source>
        <translation>zum Betrachter</translation>
    </message>
    <message>
        <source>trajectory of the plan; empty: that planned ventriculostomy whose entry is nearest to the catheter</source>
        <translation>Trajektorie des Plans; ohne Namen die Ventrikulostomie mit dem nächsten Eintritt</translation>
    </message>
    <message>
        <source>turn of the trunk to the left: 0 supine, 180 prone</source>
        <translation>Drehung des Rumpfs nach links: 0 Rückenlage, 180 Bauchlage</translation>
    </message>
    <message>
        <source>two cups, or a foot and a jaw</source>
        <translation>zwei Löffel, oder ein Fuß und eine Backe</translation>
    </message>
    <message>
        <source>widest air space in the bone that the saw cuts through</source>
        <translation>größter Hohlraum im Knochen, den die Säge durchtrennt</translation>
    </message>
    <message>
        <source>widest gap in the bone that the outline may cross</source>
        <translation>breiteste Lücke im Knochen, die der Umriss überqueren darf</translation>
    </message>
    <message>
        <source>width of the cut</source>
        <translation>Breite des Schnitts</translation>
    </message>
    <message>
        <source>width of the jaws</source>
        <translation>Breite des Mauls</translation>
    </message>
    <message>
        <source>width of the window, from black to white</source>
        <translation>Breite des Fensters, von Schwarz bis Weiß</translation>
    </message>
    <message>
        <source>without irrigation</source>
        <translation>ohne Spülung</translation>
    </message>
    <message>
        <source>world frame</source>
        <translation>Weltkoordinaten</translation>
    </message>
    <message>
        <source>Bone</source>
        <translation>Knochen</translation>
    </message>
    <message>
        <source>Air</source>
        <translation>Luft</translation>
    </message>
    <message>
        <source>Soft tissue</source>
        <translation>Weichteile</translation>
    </message>
    <message>
        <source>Cortical bone</source>
        <translation>Kortikaler Knochen</translation>
    </message>
    <message>
        <source>Diploe</source>
        <translation>Diploe</translation>
    </message>
    <message>
        <source>Dura</source>
        <translation>Dura</translation>
    </message>
    <message>
        <source>CSF</source>
        <translation>Liquor</translation>
    </message>
    <message>
        <source>Brain</source>
        <translation>Gehirn</translation>
    </message>
    <message>
        <source>Ventricle left</source>
        <translation>Linker Ventrikel</translation>
    </message>
    <message>
        <source>Ventricle right</source>
        <translation>Rechter Ventrikel</translation>
    </message>
    <message>
        <source>Tooth</source>
        <translation>Zähne</translation>
    </message>
    <message>
        <source>Venous sinus</source>
        <translation>Venöser Sinus</translation>
    </message>
    <message>
        <source>Tumour</source>
        <translation>Tumor</translation>
    </message>
    <message>
        <source>Disc</source>
        <translation>Bandscheibe</translation>
    </message>
    <message>
        <source>Dural sac</source>
        <translation>Durasack</translation>
    </message>
    <message>
        <source>Nerve root</source>
        <translation>Nervenwurzel</translation>
    </message>
    <message>
        <source>Vessel</source>
        <translation>Gefäß</translation>
    </message>
    <message>
        <source>Ligamentum flavum</source>
        <translation>Ligamentum flavum</translation>
    </message>
    <message>
        <source>Sinus</source>
        <translation>Sinus</translation>
    </message>
    <message>
        <source>bone</source>
        <translation>Knochen</translation>
    </message>
    <message>
        <source>dura</source>
        <translation>Dura</translation>
    </message>
    <message>
        <source>csf</source>
        <translation>Liquor</translation>
    </message>
    <message>
        <source>brain</source>
        <translation>Gehirn</translation>
    </message>
    <message>
        <source>ventricle left</source>
        <translation>linker Ventrikel</translation>
    </message>
    <message>
        <source>ventricle right</source>
        <translation>rechter Ventrikel</translation>
    </message>
    <message>
        <source>venous sinus</source>
        <translation>venöser Sinus</translation>
    </message>
    <message>
        <source>tumour</source>
        <translation>Tumor</translation>
    </message>
    <message>
        <source>disc</source>
        <translation>Bandscheibe</translation>
    </message>
    <message>
        <source>dural sac</source>
        <translation>Durasack</translation>
    </message>
    <message>
        <source>nerve root</source>
        <translation>Nervenwurzel</translation>
    </message>
    <message>
        <source>vessel</source>
        <translation>Gefäß</translation>
    </message>
    <message>
        <source>ligamentum flavum</source>
        <translation>Ligamentum flavum</translation>
    </message>
    <message>
        <source>spinal cord</source>
        <translation>Rückenmark</translation>
    </message>
    <message>
        <source>the target</source>
        <translation>das Ziel</translation>
    </message>
    <message>
        <source>AP</source>
        <translation>AP</translation>
    </message>
    <message>
        <source>Lateral</source>
        <translation>Seitlich</translation>
    </message>
    <message>
        <source>Inlet</source>
        <translation>Inlet</translation>
    </message>
    <message>
        <source>Outlet</source>
        <translation>Outlet</translation>
    </message>
    <message>
        <source>Oblique</source>
        <translation>Schräg</translation>
    </message>
    <message>
        <source>Subdural</source>
        <translation>Subdural</translation>
    </message>
    <message>
        <source>Stroke</source>
        <translation>Schlaganfall</translation>
    </message>
    <message>
        <source>Whole</source>
        <translation>Gesamt</translation>
    </message>
    <message>
        <source>%1 (behind)</source>
        <translation>%1 (verdeckt)</translation>
    </message>
    <message>
        <source>good</source>
        <translation>gut</translation>
    </message>
    <message>
        <source>fair</source>
        <translation>mäßig</translation>
    </message>
    <message>
        <source>bad</source>
        <translation>schlecht</translation>
    </message>
    <message>
        <source>critical</source>
        <translation>kritisch</translation>
    </message>
    <message>
        <source>%1 of %2 points</source>
        <translation>%1 von %2 Punkten</translation>
    </message>
    <message>
        <source>%1 of %2</source>
        <translation>%1 von %2</translation>
    </message>
    <message>
        <source>critical: %1</source>
        <translation>kritisch: %1</translation>
    </message>
    <message>
        <source>%1 (at least %2 for full points)</source>
        <translation>%1 (mindestens %2 für alle Punkte)</translation>
    </message>
    <message>
        <source>%1 (at most %2 for full points)</source>
        <translation>%1 (höchstens %2 für alle Punkte)</translation>
    </message>
    <message>
        <source>motion</source>
        <translation>Bewegung</translation>
    </message>
    <message>
        <source>force</source>
        <translation>Kraft</translation>
    </message>
    <message>
        <source>drilling</source>
        <translation>Bohren</translation>
    </message>
    <message>
        <source>procedure</source>
        <translation>Eingriff</translation>
    </message>
    <message>
        <source>clamp</source>
        <translation>Klemme</translation>
    </message>
    <message>
        <source>posture</source>
        <translation>Lagerung</translation>
    </message>
    <message>
        <source>X-ray</source>
        <translation>Röntgen</translation>
    </message>
    <message>
        <source>kerma</source>
        <translation>Kerma</translation>
    </message>
    <message>
        <source>kerma-area product</source>
        <translation>Dosisflächenprodukt</translation>
    </message>
    <message>
        <source>shots</source>
        <translation>Aufnahmen</translation>
    </message>
    <message>
        <source>time</source>
        <translation>Zeit</translation>
    </message>
    <message>
        <source>angle to outer table</source>
        <translation>Winkel zur Tabula externa</translation>
    </message>
    <message>
        <source>angle to plan</source>
        <translation>Winkel zum Plan</translation>
    </message>
    <message>
        <source>clearance of forbidden structures</source>
        <translation>Abstand von verbotenen Strukturen</translation>
    </message>
    <message>
        <source>depth from dura</source>
        <translation>Tiefe ab Dura</translation>
    </message>
    <message>
        <source>depth from outer table</source>
        <translation>Tiefe ab Tabula externa</translation>
    </message>
    <message>
        <source>entry to plan</source>
        <translation>Eintritt zum Plan</translation>
    </message>
    <message>
        <source>forbidden structures crossed</source>
        <translation>gekreuzte verbotene Strukturen</translation>
    </message>
    <message>
        <source>grade of the tip</source>
        <translation>Grad der Spitze</translation>
    </message>
    <message>
        <source>length in ventricles</source>
        <translation>Länge in den Ventrikeln</translation>
    </message>
    <message>
        <source>passages</source>
        <translation>Versuche</translation>
    </message>
    <message>
        <source>tip to target</source>
        <translation>Spitze zum Ziel</translation>
    </message>
    <message>
        <source>at a limit</source>
        <translation>an einer Grenze</translation>
    </message>
    <message>
        <source>axis to the centre of the skull</source>
        <translation>Achse zur Schädelmitte</translation>
    </message>
    <message>
        <source>difference within the pair</source>
        <translation>Unterschied im Paar</translation>
    </message>
    <message>
        <source>fitted</source>
        <translation>angepasst</translation>
    </message>
    <message>
        <source>largest height over the sweatband</source>
        <translation>größte Höhe über dem Stirnband</translation>
    </message>
    <message>
        <source>least angle of a pin to the bone</source>
        <translation>kleinster Winkel eines Dorns zum Knochen</translation>
    </message>
    <message>
        <source>least bone at a pin</source>
        <translation>geringste Knochendicke an einem Dorn</translation>
    </message>
    <message>
        <source>pin to approach</source>
        <translation>Dorn zum Zugang</translation>
    </message>
    <message>
        <source>pin to its planned position</source>
        <translation>Dorn zur geplanten Position</translation>
    </message>
    <message>
        <source>breakthroughs</source>
        <translation>Durchbrüche</translation>
    </message>
    <message>
        <source>deepest plunge</source>
        <translation>tiefstes Einsinken</translation>
    </message>
    <message>
        <source>warmest bone, above body temperature</source>
        <translation>wärmster Knochen, über Körpertemperatur</translation>
    </message>
    <message>
        <source>area</source>
        <translation>Fläche</translation>
    </message>
    <message>
        <source>distance from plan</source>
        <translation>Abstand vom Plan</translation>
    </message>
    <message>
        <source>exposed part of %1</source>
        <translation>freigelegter Anteil: %1</translation>
    </message>
    <message>
        <source>largest distance from plan</source>
        <translation>größter Abstand vom Plan</translation>
    </message>
    <message>
        <source>margin around %1</source>
        <translation>Rand um: %1</translation>
    </message>
    <message>
        <source>roundness</source>
        <translation>Rundheit</translation>
    </message>
    <message>
        <source>saw in %1</source>
        <translation>Säge in: %1</translation>
    </message>
    <message>
        <source>idle time</source>
        <translation>Ruhezeit</translation>
    </message>
    <message>
        <source>jerk</source>
        <translation>Ruck</translation>
    </message>
    <message>
        <source>log dimensionless jerk</source>
        <translation>logarithmischer dimensionsloser Ruck</translation>
    </message>
    <message>
        <source>mean length of strokes</source>
        <translation>mittlere Länge der Striche</translation>
    </message>
    <message>
        <source>mean speed</source>
        <translation>mittlere Geschwindigkeit</translation>
    </message>
    <message>
        <source>path</source>
        <translation>Weg</translation>
    </message>
    <message>
        <source>peak speed</source>
        <translation>Spitzengeschwindigkeit</translation>
    </message>
    <message>
        <source>spread of strokes</source>
        <translation>Streuung der Striche</translation>
    </message>
    <message>
        <source>strokes</source>
        <translation>Striche</translation>
    </message>
    <message>
        <source>time near forbidden structures</source>
        <translation>Zeit nahe verbotenen Strukturen</translation>
    </message>
    <message>
        <source>working time</source>
        <translation>Arbeitszeit</translation>
    </message>
    <message>
        <source>mean</source>
        <translation>Mittel</translation>
    </message>
    <message>
        <source>peak</source>
        <translation>Spitze</translation>
    </message>
    <message>
        <source>time pressing near forbidden structures</source>
        <translation>Zeit mit Druck nahe verbotenen Strukturen</translation>
    </message>
    <message>
        <source>angle of the approach to the vertical</source>
        <translation>Winkel des Zugangs zur Senkrechten</translation>
    </message>
    <message>
        <source>neck bend</source>
        <translation>Halsneigung</translation>
    </message>
    <message>
        <source>neck flexion</source>
        <translation>Halsbeugung</translation>
    </message>
    <message>
        <source>neck rotation</source>
        <translation>Halsdrehung</translation>
    </message>
    <message>
        <source>complete</source>
        <translation>vollständig</translation>
    </message>
    <message>
        <source>beyond bone</source>
        <translation>jenseits des Knochens</translation>
    </message>
    <message>
        <source>body breach</source>
        <translation>Durchbruch des Wirbelkörpers</translation>
    </message>
    <message>
        <source>breach</source>
        <translation>Durchbruch</translation>
    </message>
    <message>
        <source>canal gained</source>
        <translation>gewonnene Kanalfläche</translation>
    </message>
    <message>
        <source>entries</source>
        <translation>Eintritte</translation>
    </message>
    <message>
        <source>grade</source>
        <translation>Grad</translation>
    </message>
    <message>
        <source>intensity in the core</source>
        <translation>Intensität im Kern</translation>
    </message>
    <message>
        <source>left pars</source>
        <translation>linke Pars</translation>
    </message>
    <message>
        <source>right pars</source>
        <translation>rechte Pars</translation>
    </message>
    <message>
        <source>length to track</source>
        <translation>Länge zum Bohrkanal</translation>
    </message>
    <message>
        <source>nearest distance</source>
        <translation>kleinster Abstand</translation>
    </message>
    <message>
        <source>opened length</source>
        <translation>geöffnete Länge</translation>
    </message>
    <message>
        <source>opened width</source>
        <translation>geöffnete Breite</translation>
    </message>
    <message>
        <source>tip to plan</source>
        <translation>Spitze zum Plan</translation>
    </message>
    <message>
        <source>time inside</source>
        <translation>Zeit im Inneren</translation>
    </message>
    <message>
        <source>torn</source>
        <translation>verletzt</translation>
    </message>
    <message>
        <source>refused requests</source>
        <translation>abgelehnte Anforderungen</translation>
    </message>
    <message>
        <source>Compared with %1.</source>
        <translation>Verglichen mit %1.</translation>
    </message>
    <message>
        <source>The tool was never nearer. Larger distances are not measured.</source>
        <translation>Das Werkzeug war nie näher. Größere Abstände werden nicht gemessen.</translation>
    </message>
    <message>
        <source>The operation ended in the step %1.</source>
        <translation>Die Operation endete im Schritt %1.</translation>
    </message>
    <message>
        <source>No stroke lasted a quarter of a second and changed its speed.</source>
        <translation>Kein Strich dauerte eine Viertelsekunde und änderte seine Geschwindigkeit.</translation>
    </message>
    <message>
        <source>The foot of the saw strips it off the bone.</source>
        <translation>Der Fuß der Säge löst sie vom Knochen.</translation>
    </message>
    <message>
        <source>The tip is in %1.</source>
        <translation>Die Spitze ist in: %1.</translation>
    </message>
    <message>
        <source>The tip is outside the ventricles.</source>
        <translation>Die Spitze ist außerhalb der Ventrikel.</translation>
    </message>
    <message>
        <source>The plan has no outline; add one.</source>
        <translation>Der Plan hat keinen Umriss; einen hinzufügen.</translation>
    </message>
    <message>
        <source>The catheter did not move in the head.</source>
        <translation>Der Katheter wurde nicht im Kopf bewegt.</translation>
    </message>
    <message>
        <source>Wall: %1.</source>
        <translation>Wand: %1.</translation>
    </message>
    <message>
        <source>medial</source>
        <translation>medial</translation>
    </message>
    <message>
        <source>lateral</source>
        <translation>lateral</translation>
    </message>
    <message>
        <source>above</source>
        <translation>oben</translation>
    </message>
    <message>
        <source>below</source>
        <translation>unten</translation>
    </message>
    <message>
        <source>front</source>
        <translation>vorn</translation>
    </message>
    <message>
        <source>No structure is watched, since none is marked as forbidden. To be warned of injuries, import the scan with labels of dura, nerves or vessels, and mark these as forbidden.</source>
        <translation>Keine Struktur wird überwacht, da keine als verboten markiert ist. Für Warnungen die Aufnahme mit Labels von Dura, Nerven oder Gefäßen importieren und diese als verboten markieren.</translation>
    </message>
    <message>
        <source>The solid shape has disconnected parts, such as a table, a head holder or another bone. To omit them, check &quot;Largest part only&quot; and press &quot;Use&quot;.</source>
        <translation>Der Festkörper hat getrennte Teile, etwa einen Tisch, Kopfhalter oder anderen Knochen. Zum Weglassen „Nur größter Teil“ ankreuzen und „Verwenden“ drücken.</translation>
    </message>
    <message>
        <source>burr hole over the tumour</source>
        <translation>Bohrloch über dem Tumor</translation>
    </message>
    <message>
        <source>left ventriculostomy</source>
        <translation>linke Ventrikulostomie</translation>
    </message>
    <message>
        <source>right ventriculostomy</source>
        <translation>rechte Ventrikulostomie</translation>
    </message>
    <message>
        <source>vertex</source>
        <translation>Scheitel</translation>
    </message>
    <message>
        <source>inion</source>
        <translation>Inion</translation>
    </message>
    <message>
        <source>nasion</source>
        <translation>Nasion</translation>
    </message>
    <message>
        <source>glabella</source>
        <translation>Glabella</translation>
    </message>
    <message>
        <source>left tragus</source>
        <translation>linker Tragus</translation>
    </message>
    <message>
        <source>right tragus</source>
        <translation>rechter Tragus</translation>
    </message>
    <message>
        <source>left Kocher&apos;s point</source>
        <translation>linker Kocher-Punkt</translation>
    </message>
    <message>
        <source>right Kocher&apos;s point</source>
        <translation>rechter Kocher-Punkt</translation>
    </message>
    <message>
        <source>left foramen of Monro</source>
        <translation>linkes Foramen Monroi</translation>
    </message>
    <message>
        <source>right foramen of Monro</source>
        <translation>rechtes Foramen Monroi</translation>
    </message>
    <message>
        <source>craniotomy</source>
        <translation>Kraniotomie</translation>
    </message>
    <message>
        <source>soft tissue</source>
        <translation>Weichteile</translation>
    </message>
    <message>
        <source>cortical bone</source>
        <translation>Kompakta</translation>
    </message>
    <message>
        <source>diploe</source>
        <translation>Diploe</translation>
    </message>
    <message>
        <source>tooth</source>
        <translation>Zahn</translation>
    </message>
    <message>
        <source>%1 left pedicle</source>
        <translation>%1 linker Pedikel</translation>
    </message>
    <message>
        <source>%1 right pedicle</source>
        <translation>%1 rechter Pedikel</translation>
    </message>
    <message>
        <source>%1 left cortical</source>
        <translation>%1 links kortikal</translation>
    </message>
    <message>
        <source>%1 right cortical</source>
        <translation>%1 rechts kortikal</translation>
    </message>
    <message>
        <source>%1 left nerve root</source>
        <translation>%1 linke Nervenwurzel</translation>
    </message>
    <message>
        <source>%1 right nerve root</source>
        <translation>%1 rechte Nervenwurzel</translation>
    </message>
    <message>
        <source>disc %1</source>
        <translation>Bandscheibe %1</translation>
    </message>
    <message>
        <source>behind</source>
        <translation>verdeckt</translation>
    </message>
    <message>
        <source>hand</source>
        <translation>Hand</translation>
    </message>
    <message>
        <source>normal</source>
        <translation>Normale</translation>
    </message>
    <message>
        <source>mean %1</source>
        <translation>Mittel %1</translation>
    </message>
    <message>
        <source>straight %1 mm</source>
        <translation>gerade %1 mm</translation>
    </message>
    <message>
        <source>outline %1 mm</source>
        <translation>Umriss %1 mm</translation>
    </message>
    <message>
        <source>X-ray, held</source>
        <translation>Röntgenbild, gehalten</translation>
    </message>
    <message>
        <source>X-ray, live</source>
        <translation>Röntgenbild, live</translation>
    </message>
    <message>
        <source>along the tool</source>
        <translation>entlang des Werkzeugs</translation>
    </message>
    <message>
        <source>plan (ring: entry)</source>
        <translation>Plan (Ring: Eintritt)</translation>
    </message>
    <message>
        <source>brain surface</source>
        <translation>Hirnoberfläche</translation>
    </message>
    <message>
        <source>ventricles</source>
        <translation>Ventrikel</translation>
    </message>
    <message>
        <source>skull</source>
        <translation>Schädel</translation>
    </message>
    <message>
        <source>spine</source>
        <translation>Wirbelsäule</translation>
    </message>
    <message>
        <source>head</source>
        <translation>Kopf</translation>
    </message>
    <message>
        <source>window %1 / %2</source>
        <translation>Fenster %1 / %2</translation>
    </message>
    <message>
        <source>window %1 / %2, mean of %3 mm</source>
        <translation>Fenster %1 / %2, Mittel über %3 mm</translation>
    </message>
    <message>
        <source>%1: %2 mm²</source>
        <translation>%1: %2 mm²</translation>
    </message>
    <message>
        <source>models %1 mm², outside bone %2</source>
        <translation>Modelle %1 mm², außerhalb von Knochen %2</translation>
    </message>
    <message>
        <source>%1 (do not cut)</source>
        <translation>%1 (nicht schneiden)</translation>
    </message>
    <message>
        <source>flap of %1 cm²</source>
        <translation>Deckel von %1 cm²</translation>
    </message>
    <message>
        <source>%1 to %2</source>
        <translation>%1 bis %2</translation>
    </message>
    <message>
        <source>X-ray %1 s, %2 mGy cm²</source>
        <translation>Röntgen %1 s, %2 mGy cm²</translation>
    </message>
    <message>
        <source>The tool pushes the %1 aside by %2 mm.</source>
        <translation>Das Werkzeug drückt %1 um %2 mm zur Seite.</translation>
    </message>
    <message>
        <source>shape: bone, 300 HU and above (another threshold can be chosen; a spine usually needs 150 HU)</source>
        <translation>Form: Knochen ab 300 HU (eine andere Schwelle ist wählbar; eine Wirbelsäule braucht meist 150 HU)</translation>
    </message>
    <message>
        <source>grey</source>
        <translation>grau</translation>
    </message>
    <message>
        <source>%1 %2 (at least %3 for full points)</source>
        <translation>%1 %2 (mindestens %3 für volle Punkte)</translation>
    </message>
    <message>
        <source>%1 %2 (at most %3 for full points)</source>
        <translation>%1 %2 (höchstens %3 für volle Punkte)</translation>
    </message>
    <message>
        <source>– of %1</source>
        <translation>– von %1</translation>
    </message>
    <message>
        <source>number of the screw among the bodies; 0: the last screw</source>
        <translation>Nummer der Schraube unter den Körpern; 0: die letzte Schraube</translation>
    </message>
    <message>
        <source>Screw</source>
        <translation>Schraube</translation>
    </message>
    <message>
        <source>distances of entry and tip from the plan, in sum, from which on there are no points</source>
        <translation>Abstände von Eintritt und Spitze vom Plan, in der Summe, ab denen es keine Punkte gibt</translation>
    </message>
    <message>
        <source>No points from a plan error of</source>
        <translation>Keine Punkte ab einem Planfehler von</translation>
    </message>
    <message>
        <source>No points from a depth error of</source>
        <translation>Keine Punkte ab einem Tiefenfehler von</translation>
    </message>
    <message>
        <source>difference between the lengths of screw and track from which on there are no points</source>
        <translation>Unterschied der Längen von Schraube und Bohrkanal, ab dem es keine Punkte gibt</translation>
    </message>
    <message>
        <source>no object near the tool is touched through depth images</source>
        <translation>Kein Objekt in der Nähe des Werkzeugs wird über Tiefenbilder berührt</translation>
    </message>
    <message>
        <source>open a model or a depth video for depth images (option depth), and move the tool to it</source>
        <translation>Modell oder Tiefenvideo für Tiefenbilder öffnen (Option depth) und das Werkzeug dorthin bewegen</translation>
    </message>
    <message>
        <source>refused starts of the craniotome</source>
        <translation>abgewiesene Ansätze des Kraniotoms</translation>
    </message>
    <message>
        <source>The running tool touches the %1, %2 mm deep; it tears at %3 mm. Lift it.</source>
        <translation>Das laufende Werkzeug berührt %1, %2 mm tief; ab %3 mm reißt die Struktur. Anheben.</translation>
    </message>
    <message>
        <source>The running tool touches the %1, %2 mm deep; it tears at %3 mm. Click away from the entry to withdraw it.</source>
        <translation>Das laufende Werkzeug berührt %1, %2 mm tief; ab %3 mm reißt die Struktur. Neben den Eintritt klicken, um es zurückzuziehen.</translation>
    </message>
    <message>
        <source>The running tool touches the %1, %2 mm deep; it tears at %3 mm. Move the cursor away to withdraw it.</source>
        <translation>Das laufende Werkzeug berührt %1, %2 mm tief; ab %3 mm reißt die Struktur. Den Zeiger wegbewegen, um es zurückzuziehen.</translation>
    </message>
    <message>
        <source>The running tool touches the %1, %2 mm deep; it tears at %3 mm. Release the button to lift it.</source>
        <translation>Das laufende Werkzeug berührt %1, %2 mm tief; ab %3 mm reißt die Struktur. Die Taste loslassen, um es anzuheben.</translation>
    </message>
    <message>
        <source>The running tool touches the %1, %2 mm deep; it tears at %3 mm. Move the cursor away to lift it.</source>
        <translation>Das laufende Werkzeug berührt %1, %2 mm tief; ab %3 mm reißt die Struktur. Den Zeiger wegbewegen, um es anzuheben.</translation>
    </message>
    <message>
        <source>Falcon: pull the grip out, then push it in fully. The light turns blue when it is ready.</source>
        <translation>Falcon: den Griff herausziehen, dann ganz hineindrücken. Das Licht wird blau, wenn das Gerät bereit ist.</translation>
    </message>
    <message>
        <source>Touch: hold the arm at its reset position for some seconds.</source>
        <translation>Touch: den Arm einige Sekunden in seiner Grundstellung halten.</translation>
    </message>
    <message>
        <source>Touch: put the stylus into the inkwell until the device is calibrated.</source>
        <translation>Touch: den Stift in das Tintenfass stecken, bis das Gerät kalibriert ist.</translation>
    </message>
    <message>
        <source>loading the firmware of the Falcon, attempt %1 of %2</source>
        <translation>die Firmware des Falcon wird geladen, Versuch %1 von %2</translation>
    </message>
    <message>
        <source>the opening of the device was cancelled</source>
        <translation>das Öffnen des Geräts wurde abgebrochen</translation>
    </message>
    <message>
        <source>open it again, or use the mouse</source>
        <translation>es erneut öffnen oder die Maus verwenden</translation>
    </message>
    <message>
        <source>there is no bone flap to judge</source>
        <translation>es gibt keinen Knochendeckel, der beurteilt werden kann</translation>
    </message>
    <message>
        <source>cut the flap first, with the craniotome or along the outline (cut-flap)</source>
        <translation>den Deckel zuerst sägen, mit dem Kraniotom oder entlang der Umrisslinie (cut-flap)</translation>
    </message>
    <message>
        <source>%1 mm deep</source>
        <translation>%1 mm tief</translation>
    </message>
    <message>
        <source>The foot goes under the marked edge. Press again to bite.</source>
        <translation>Der Fuß gleitet unter den markierten Rand. Zum Abbeißen nochmals drücken.</translation>
    </message>
    <message>
        <source>The scan has no labels: soft bone below the threshold also counts as outside.</source>
        <translation>Die Aufnahme hat keine Labels: auch weicher Knochen unter dem Schwellenwert zählt als außerhalb.</translation>
    </message>
    <message>
        <source>%1 left</source>
        <translation>%1 links</translation>
    </message>
    <message>
        <source>%1 right</source>
        <translation>%1 rechts</translation>
    </message>
    <message>
        <source>The computer is too busy: the tool is stopped.</source>
        <translation>Der Rechner ist überlastet: das Werkzeug ist angehalten.</translation>
    </message>
    <message>
        <source>No piece is free yet: bone still holds it. Cut again where the kerf is not open, first at the holes.</source>
        <translation>Noch ist kein Stück frei: Knochen hält es. Dort nochmals schneiden, wo der Sägespalt nicht offen ist, zuerst an den Löchern.</translation>
    </message>
</context>
<context>
    <name>trephine::view::CasePanel</name>
    <message>
        <source>Make a case</source>
        <translation>Fall erstellen</translation>
    </message>
    <message>
        <source>structure</source>
        <translation>Struktur</translation>
    </message>
    <message>
        <source>do not enter</source>
        <translation>nicht verletzen</translation>
    </message>
    <message>
        <source>target</source>
        <translation>Ziel</translation>
    </message>
    <message>
        <source>finding</source>
        <translation>Befund</translation>
    </message>
    <message>
        <source>all points at</source>
        <translation>alle Punkte bei</translation>
    </message>
    <message>
        <source>none at</source>
        <translation>keine bei</translation>
    </message>
    <message>
        <source>points</source>
        <translation>Punkte</translation>
    </message>
    <message>
        <source>not the name of a patient</source>
        <translation>nicht der Name eines Patienten</translation>
    </message>
    <message>
        <source>No procedure: free practice</source>
        <translation>Kein Eingriff: freies Üben</translation>
    </message>
    <message>
        <source>Steps of a file ...</source>
        <translation>Schritte einer Datei ...</translation>
    </message>
    <message>
        <source>Name</source>
        <translation>Name</translation>
    </message>
    <message>
        <source>Procedure</source>
        <translation>Eingriff</translation>
    </message>
    <message>
        <source>Structures of the scan&apos;s labels</source>
        <translation>Strukturen aus den Labels der Aufnahme</translation>
    </message>
    <message>
        <source>This scan has no labels: no structure can be forbidden or a target.</source>
        <translation>Diese Aufnahme hat keine Labels: Keine Struktur kann verboten oder Ziel sein.</translation>
    </message>
    <message>
        <source>Plan (double click: rename; Delete: remove)</source>
        <translation>Plan (Doppelklick: umbenennen; Entf: entfernen)</translation>
    </message>
    <message>
        <source>Trajectory</source>
        <translation>Trajektorie</translation>
    </message>
    <message>
        <source>Mark entry and target, in the picture or in slices</source>
        <translation>Eintritt und Ziel im Bild oder in Schichten markieren</translation>
    </message>
    <message>
        <source>Landmark</source>
        <translation>Landmarke</translation>
    </message>
    <message>
        <source>Mark one position</source>
        <translation>Eine Position markieren</translation>
    </message>
    <message>
        <source>Outline</source>
        <translation>Umriss</translation>
    </message>
    <message>
        <source>Mark three or more positions around an opening, then Enter</source>
        <translation>Drei oder mehr Positionen um eine Öffnung markieren, dann Eingabetaste</translation>
    </message>
    <message>
        <source>Limits of the score</source>
        <translation>Grenzen der Bewertung</translation>
    </message>
    <message>
        <source>Save the case ...</source>
        <translation>Fall speichern ...</translation>
    </message>
    <message>
        <source>Write the case into a new folder, which can be copied to others</source>
        <translation>Den Fall in einen neuen Ordner schreiben, der weitergegeben werden kann</translation>
    </message>
    <message>
        <source>Remove</source>
        <translation>Entfernen</translation>
    </message>
    <message>
        <source>%1: trajectory, %L2 mm</source>
        <translation>%1: Trajektorie, %L2 mm</translation>
    </message>
    <message>
        <source>%1: landmark</source>
        <translation>%1: Landmarke</translation>
    </message>
    <message>
        <source>%1: outline of %2 positions</source>
        <translation>%1: Umriss aus %2 Positionen</translation>
    </message>
    <message>
        <source>This is not a number: the previous value remains.</source>
        <translation>Das ist keine Zahl: Der vorige Wert bleibt.</translation>
    </message>
    <message>
        <source>Rename</source>
        <translation>Umbenennen</translation>
    </message>
    <message>
        <source>Name, such as &quot;L4 left pedicle&quot;:</source>
        <translation>Name, etwa „Pedikel L4 links“:</translation>
    </message>
</context>
<context>
    <name>trephine::view::EventLog</name>
    <message>
        <source>Event log</source>
        <translation>Ereignisliste</translation>
    </message>
</context>
<context>
    <name>trephine::view::FieldForm</name>
    <message>
        <source>More settings</source>
        <translation>Weitere Einstellungen</translation>
    </message>
</context>
<context>
    <name>trephine::view::ForceBar</name>
    <message>
        <source>Force</source>
        <translation>Kraft</translation>
    </message>
    <message>
        <source>%L1 N, at its limit</source>
        <translation>%L1 N, an der Grenze</translation>
    </message>
</context>
<context>
    <name>trephine::view::ForcePanel</name>
    <message>
        <source>Why this force?</source>
        <translation>Warum diese Kraft?</translation>
    </message>
    <message>
        <source>part</source>
        <translation>Anteil</translation>
    </message>
    <message>
        <source>left, N</source>
        <translation>links, N</translation>
    </message>
    <message>
        <source>back, N</source>
        <translation>hinten, N</translation>
    </message>
    <message>
        <source>up, N</source>
        <translation>oben, N</translation>
    </message>
    <message>
        <source>size, N</source>
        <translation>Betrag, N</translation>
    </message>
    <message>
        <source>torque, N mm</source>
        <translation>Drehmoment, N mm</translation>
    </message>
    <message>
        <source>Previous tick</source>
        <translation>Voriger Takt</translation>
    </message>
    <message>
        <source>Next tick</source>
        <translation>Nächster Takt</translation>
    </message>
    <message>
        <source>Pause the replay to see the parts of the force.</source>
        <translation>Die Wiedergabe anhalten, um die Anteile der Kraft zu sehen.</translation>
    </message>
    <message>
        <source>The replay is before its first tick.</source>
        <translation>Die Wiedergabe steht vor ihrem ersten Takt.</translation>
    </message>
    <message>
        <source>Tick %1, %L2 s.</source>
        <translation>Takt %1, %L2 s.</translation>
    </message>
    <message>
        <source>sum</source>
        <translation>Summe</translation>
    </message>
</context>
<context>
    <name>trephine::view::HelpOverlay</name>
    <message>
        <source>Move the mouse</source>
        <translation>Maus bewegen</translation>
    </message>
    <message>
        <source>move the tool over the bone under the cursor</source>
        <translation>das Werkzeug über den Knochen unter dem Mauszeiger führen</translation>
    </message>
    <message>
        <source>Hold left, or Space</source>
        <translation>Links halten oder Leertaste</translation>
    </message>
    <message>
        <source>press the tool into the bone: touch and drill</source>
        <translation>das Werkzeug in den Knochen drücken: tasten und bohren</translation>
    </message>
    <message>
        <source>Arrows (Shift: 0.2 mm)</source>
        <translation>Pfeile (Umschalt: 0,2 mm)</translation>
    </message>
    <message>
        <source>move the tip by 1 mm</source>
        <translation>die Spitze um 1 mm bewegen</translation>
    </message>
    <message>
        <source>Wheel, PgUp, PgDn</source>
        <translation>Mausrad, Bild auf, Bild ab</translation>
    </message>
    <message>
        <source>change the depth of a press or of an inserted tool; slide a Kerrison&apos;s foot</source>
        <translation>Tiefe des Drucks oder eines eingeführten Werkzeugs ändern; Fuß der Kerrison-Stanze schieben</translation>
    </message>
    <message>
        <source>Drag middle,  W A S D</source>
        <translation>Mitte ziehen,  W A S D</translation>
    </message>
    <message>
        <source>tilt the tool; turn it about its shaft: middle button + wheel, or  ,  and  .</source>
        <translation>Werkzeug kippen; um den Schaft drehen: mittlere Taste + Rad, oder  ,  und  .</translation>
    </message>
    <message>
        <source>K</source>
        <translation>K</translation>
    </message>
    <message>
        <source>hold the shaft upright on the bone, toward you, or fixed</source>
        <translation>Schaft senkrecht zum Knochen, zu Ihnen gerichtet oder fest halten</translation>
    </message>
    <message>
        <source>Drag right, Ctrl + arrows</source>
        <translation>Rechts ziehen, Strg + Pfeile</translation>
    </message>
    <message>
        <source>turn the picture; Shift + right: move it</source>
        <translation>Bild drehen; Umschalt + rechts: verschieben</translation>
    </message>
    <message>
        <source>Ctrl + wheel</source>
        <translation>Strg + Mausrad</translation>
    </message>
    <message>
        <source>zoom</source>
        <translation>zoomen</translation>
    </message>
    <message>
        <source>+  and  -</source>
        <translation>+  und  -</translation>
    </message>
    <message>
        <source>select a larger or a smaller burr</source>
        <translation>größere oder kleinere Fräse wählen</translation>
    </message>
    <message>
        <source>Ctrl+Z, Ctrl+Y  (U, Y)</source>
        <translation>Strg+Z, Strg+Y  (U, Y)</translation>
    </message>
    <message>
        <source>undo or redo a change</source>
        <translation>Änderung zurücknehmen oder wiederholen</translation>
    </message>
    <message>
        <source>Ctrl+B, Ctrl+G</source>
        <translation>Strg+B, Strg+G</translation>
    </message>
    <message>
        <source>start a branch here; go to another branch</source>
        <translation>hier einen Zweig beginnen; zu einem anderen Zweig gehen</translation>
    </message>
    <message>
        <source>Ctrl+D</source>
        <translation>Strg+D</translation>
    </message>
    <message>
        <source>compare with another state</source>
        <translation>mit einem anderen Zustand vergleichen</translation>
    </message>
    <message>
        <source>Ctrl+R</source>
        <translation>Strg+R</translation>
    </message>
    <message>
        <source>structures: show, hide, make translucent</source>
        <translation>Strukturen: zeigen, ausblenden, durchscheinend machen</translation>
    </message>
    <message>
        <source>Ctrl+1</source>
        <translation>Strg+1</translation>
    </message>
    <message>
        <source>add an anchor of a bone flap at the touched position</source>
        <translation>Ankerpunkt eines Knochendeckels an der berührten Stelle setzen</translation>
    </message>
    <message>
        <source>Shift + left,  G</source>
        <translation>Umschalt + links,  G</translation>
    </message>
    <message>
        <source>drag a touched anchor or pin; grasp or release it</source>
        <translation>berührten Ankerpunkt oder Dorn ziehen; greifen oder loslassen</translation>
    </message>
    <message>
        <source>Ctrl+F,  T</source>
        <translation>Strg+F,  T</translation>
    </message>
    <message>
        <source>detach cut pieces; grasp or release the touched piece (Shift+T: put it back)</source>
        <translation>gesägte Stücke lösen; berührtes Stück greifen oder loslassen (Umschalt+T: zurücksetzen)</translation>
    </message>
    <message>
        <source>Ctrl + Enter</source>
        <translation>Strg + Eingabe</translation>
    </message>
    <message>
        <source>go to the next step of the procedure</source>
        <translation>zum nächsten Schritt des Eingriffs gehen</translation>
    </message>
    <message>
        <source>Shift + A P L R S I,  0</source>
        <translation>Umschalt + A P L R S I,  0</translation>
    </message>
    <message>
        <source>view from the front, back, left, right, above, below; whole scan</source>
        <translation>Ansicht von vorn, hinten, links, rechts, oben, unten; ganze Aufnahme</translation>
    </message>
    <message>
        <source>C</source>
        <translation>C</translation>
    </message>
    <message>
        <source>clip the picture</source>
        <translation>Bild aufschneiden</translation>
    </message>
    <message>
        <source>F5 to F9</source>
        <translation>F5 bis F9</translation>
    </message>
    <message>
        <source>show the picture alone; with slices; X-ray and section; volume rendering; depth images</source>
        <translation>nur das Bild zeigen; mit Schichten; Röntgen und Schnitt; Volumenbild; Tiefenbildern</translation>
    </message>
    <message>
        <source>Shift + mouse, left, middle, right</source>
        <translation>Umschalt + Maus, links, Mitte, rechts</translation>
    </message>
    <message>
        <source>in a slice: show all slices through it; change the windowing; move; zoom</source>
        <translation>in einer Schicht: alle Schichten durch den Punkt; Fensterung; verschieben; zoomen</translation>
    </message>
    <message>
        <source>T, G, R, double click</source>
        <translation>T, G, R, Doppelklick</translation>
    </message>
    <message>
        <source>in a slice: show before and after; labels; the whole scan; maximise</source>
        <translation>in einer Schicht: vorher und nachher; Labels; ganze Aufnahme; maximieren</translation>
    </message>
    <message>
        <source>E,  N</source>
        <translation>E,  N</translation>
    </message>
    <message>
        <source>show or hide the event log; names of the plan: in front, all, none</source>
        <translation>Ereignisliste zeigen oder ausblenden; Namen des Plans: vorn, alle, keine</translation>
    </message>
    <message>
        <source>F</source>
        <translation>F</translation>
    </message>
    <message>
        <source>turn the force of a haptic device on again after a fault</source>
        <translation>die Kraft eines haptischen Geräts nach einem Fehler wieder einschalten</translation>
    </message>
    <message>
        <source>Ctrl+O, or drop a folder</source>
        <translation>Strg+O oder Ordner ablegen</translation>
    </message>
    <message>
        <source>open a scan (a file: Ctrl+Shift+O)</source>
        <translation>Aufnahme öffnen (Datei: Strg+Umschalt+O)</translation>
    </message>
    <message>
        <source>Ctrl+S, Ctrl+P</source>
        <translation>Strg+S, Strg+P</translation>
    </message>
    <message>
        <source>save the operated volume; the picture</source>
        <translation>operiertes Volumen speichern; das Bild</translation>
    </message>
    <message>
        <source>Ctrl + +, Ctrl + -</source>
        <translation>Strg + +, Strg + -</translation>
    </message>
    <message>
        <source>use larger or smaller text</source>
        <translation>größere oder kleinere Schrift</translation>
    </message>
    <message>
        <source>F12</source>
        <translation>F12</translation>
    </message>
    <message>
        <source>score of the operation so far, and its report</source>
        <translation>bisherige Bewertung der Operation und ihr Bericht</translation>
    </message>
    <message>
        <source>F1</source>
        <translation>F1</translation>
    </message>
    <message>
        <source>show this help</source>
        <translation>diese Hilfe zeigen</translation>
    </message>
    <message>
        <source>click to close</source>
        <translation>Klicken zum Schließen</translation>
    </message>
    <message>
        <source>M, Ctrl+Shift+A, Ctrl+Shift+T</source>
        <translation>M, Strg+Umschalt+A, Strg+Umschalt+T</translation>
    </message>
    <message>
        <source>ruler, angle, tape: click positions, in the picture or in slices</source>
        <translation>Lineal, Winkel, Maßband: Stellen anklicken, im Bild oder in Schichten</translation>
    </message>
    <message>
        <source>Backspace, Enter, Esc</source>
        <translation>Rücktaste, Eingabe, Esc</translation>
    </message>
    <message>
        <source>while positions are marked: remove the last one; finish; cancel</source>
        <translation>beim Markieren von Stellen: die letzte entfernen; beenden; abbrechen</translation>
    </message>
    <message>
        <source>Ctrl+2, Ctrl+3 ...</source>
        <translation>Strg+2, Strg+3 ...</translation>
    </message>
    <message>
        <source>further commands at the touched position: see the menu Commands</source>
        <translation>weitere Befehle an der berührten Stelle: siehe Menü Befehle</translation>
    </message>
    <message>
        <source>Wheel, Left, Right, B, F</source>
        <translation>Rad, Links, Rechts, B, F</translation>
    </message>
    <message>
        <source>in a slice: show the previous or next slice</source>
        <translation>in einer Schicht: vorige oder nächste Schicht zeigen</translation>
    </message>
    <message>
        <source>X,  Ctrl+N</source>
        <translation>X,  Strg+N</translation>
    </message>
    <message>
        <source>in a paused replay: why this force? (its parts, friction, limits); note at this time</source>
        <translation>in einer angehaltenen Wiedergabe: Warum diese Kraft? (Anteile, Reibung, Grenzen); Notiz zu dieser Zeit</translation>
    </message>
    <message>
        <source>wheel: scroll; click: close</source>
        <translation>Rad: blättern; Klick: schließen</translation>
    </message>
</context>
<context>
    <name>trephine::view::ImagePane</name>
    <message>
        <source>Select a pose of the C-arm</source>
        <translation>Stellung des C-Bogens wählen</translation>
    </message>
    <message>
        <source>Live</source>
        <translation>Live</translation>
    </message>
    <message>
        <source>Shoot</source>
        <translation>Auslösen</translation>
    </message>
    <message>
        <source>Maximise or restore this pane  (double click)</source>
        <translation>Dieses Feld maximieren oder zurücksetzen  (Doppelklick)</translation>
    </message>
    <message>
        <source>Take X-rays until switched off. Each X-ray adds dose. The last image is held.</source>
        <translation>Durchleuchten bis zum Ausschalten. Jedes Röntgenbild gibt Dosis. Das letzte Bild bleibt stehen.</translation>
    </message>
    <message>
        <source>Take one X-ray</source>
        <translation>Ein Röntgenbild aufnehmen</translation>
    </message>
    <message>
        <source>Computing the X-ray ...</source>
        <translation>Röntgenbild wird berechnet ...</translation>
    </message>
    <message>
        <source>Press Shoot, or switch Live on.</source>
        <translation>Auslösen drücken oder Live einschalten.</translation>
    </message>
    <message>
        <source>Other pose</source>
        <translation>Andere Stellung</translation>
    </message>
</context>
<context>
    <name>trephine::view::MainWindow</name>
    <message>
        <source>drawing, %1 %</source>
        <translation>zeichnet, %1 %</translation>
    </message>
    <message>
        <source>Cancel</source>
        <translation>Abbrechen</translation>
    </message>
    <message>
        <source>A session was interrupted. Continue it in the File menu.</source>
        <translation>Eine Sitzung wurde unterbrochen. Im Menü Datei kann sie fortgesetzt werden.</translation>
    </message>
    <message>
        <source>Touch a point of the outline (an anchor) or a pin of the clamp to drag it.</source>
        <translation>Einen Punkt des Umrisses (Ankerpunkt) oder einen Dorn der Klemme berühren, um ihn zu ziehen.</translation>
    </message>
    <message>
        <source>Drawing the anatomy: %1 %</source>
        <translation>Anatomie wird gezeichnet: %1 %</translation>
    </message>
    <message>
        <source>%L1 mm³ removed, 1 change</source>
        <translation>%L1 mm³ abgetragen, 1 Änderung</translation>
    </message>
    <message>
        <source>%L1 mm³ removed, %2 changes</source>
        <translation>%L1 mm³ abgetragen, %2 Änderungen</translation>
    </message>
    <message>
        <source>nothing removed yet</source>
        <translation>noch nichts abgetragen</translation>
    </message>
    <message>
        <source>Forces: %1 Hz, step %L2 µs, delay %3 µs</source>
        <translation>Kräfte: %1 Hz, Schritt %L2 µs, Verzögerung %3 µs</translation>
    </message>
    <message>
        <source>guiding the tool out of restored bone</source>
        <translation>Werkzeug wird aus wiederhergestelltem Knochen geführt</translation>
    </message>
    <message>
        <source>computing images ...</source>
        <translation>Bilder werden berechnet ...</translation>
    </message>
    <message>
        <source>ready</source>
        <translation>bereit</translation>
    </message>
    <message>
        <source>The session is saved as
%1

To continue it later, choose it on the start page of trephine simulator, or run trephine resume.</source>
        <translation>Die Sitzung ist gespeichert als
%1

Zum Fortsetzen auf der Startseite von trephine simulator wählen oder trephine resume aufrufen.</translation>
    </message>
    <message>
        <source>Preparing the tool ...</source>
        <translation>Werkzeug wird vorbereitet ...</translation>
    </message>
    <message>
        <source>Open the steps of a procedure</source>
        <translation>Schritte eines Eingriffs öffnen</translation>
    </message>
    <message>
        <source>Procedures (*.toml)</source>
        <translation>Eingriffe (*.toml)</translation>
    </message>
    <message>
        <source>Trajectory (entry, then target)</source>
        <translation>Trajektorie (Eintritt, dann Ziel)</translation>
    </message>
    <message>
        <source>Landmark</source>
        <translation>Landmarke</translation>
    </message>
    <message>
        <source>Outline</source>
        <translation>Umriss</translation>
    </message>
    <message>
        <source>Choose where to create the folder of the case</source>
        <translation>Wählen, wo der Ordner des Falls angelegt wird</translation>
    </message>
    <message>
        <source>The case is saved as the folder %1. Open it with File &gt; Open a DICOM folder or a case.</source>
        <translation>Der Fall ist als Ordner %1 gespeichert. Mit Datei &gt; DICOM-Ordner oder Fall öffnen.</translation>
    </message>
    <message>
        <source>Writing the case ...</source>
        <translation>Fall wird geschrieben ...</translation>
    </message>
    <message>
        <source>This starts again on the uncut scan. If the operation is recorded, it remains in its session file. Continue?</source>
        <translation>Dies beginnt neu mit der unveränderten Aufnahme. Eine aufgezeichnete Operation bleibt in ihrer Sitzungsdatei. Fortfahren?</translation>
    </message>
    <message>
        <source>A scan is already being opened. Wait for it, or press Cancel.</source>
        <translation>Eine Aufnahme wird schon geöffnet. Warten oder Abbrechen drücken.</translation>
    </message>
    <message>
        <source>The session opens in a window of its own.</source>
        <translation>Die Sitzung öffnet sich in einem eigenen Fenster.</translation>
    </message>
    <message>
        <source>Opening ...</source>
        <translation>Wird geöffnet ...</translation>
    </message>
    <message>
        <source>Cancelling ...</source>
        <translation>Wird abgebrochen ...</translation>
    </message>
    <message>
        <source>The scan was not opened.</source>
        <translation>Die Aufnahme wurde nicht geöffnet.</translation>
    </message>
    <message>
        <source>The previous session is saved as %1. To continue it: File &gt; Open a session to continue.</source>
        <translation>Die vorige Sitzung ist als %1 gespeichert. Fortsetzen: Datei &gt; Sitzung zum Fortsetzen öffnen.</translation>
    </message>
    <message>
        <source>saved %1</source>
        <translation>%1 gespeichert</translation>
    </message>
    <message>
        <source>drawing</source>
        <translation>zeichnet</translation>
    </message>
    <message>
        <source>tilted %1°</source>
        <translation>um %1° gekippt</translation>
    </message>
    <message>
        <source>There is no change of bone or bodies to undo. Injuries stay recorded; anchors, pins and measurements are removed with their own commands.</source>
        <translation>Es gibt keine Änderung an Knochen oder Körpern, die zurückgenommen werden kann. Verletzungen bleiben verzeichnet; Ankerpunkte, Dorne und Messungen werden mit eigenen Befehlen entfernt.</translation>
    </message>
    <message>
        <source>Names are shown for points in front of the bone.</source>
        <translation>Namen von Punkten vor dem Knochen werden gezeigt.</translation>
    </message>
    <message>
        <source>Names are shown for all points.</source>
        <translation>Namen aller Punkte werden gezeigt.</translation>
    </message>
    <message>
        <source>Names are hidden.</source>
        <translation>Namen sind ausgeblendet.</translation>
    </message>
    <message>
        <source>Grasp or touch a detached piece to put it back.</source>
        <translation>Ein gelöstes Stück greifen oder berühren, um es zurückzusetzen.</translation>
    </message>
    <message>
        <source>Touch a piece to grasp it.</source>
        <translation>Ein Stück berühren, um es zu greifen.</translation>
    </message>
    <message>
        <source>The shaft points upright on the bone.</source>
        <translation>Der Schaft steht senkrecht auf dem Knochen.</translation>
    </message>
    <message>
        <source>The shaft points toward the viewer.</source>
        <translation>Der Schaft zeigt zum Betrachter.</translation>
    </message>
    <message>
        <source>The shaft points in a fixed direction.</source>
        <translation>Der Schaft zeigt in eine feste Richtung.</translation>
    </message>
    <message>
        <source>Point at a position on the bone, or click in a slice.</source>
        <translation>Auf eine Stelle des Knochens zeigen oder in eine Schicht klicken.</translation>
    </message>
    <message>
        <source>Mark more positions first.</source>
        <translation>Zuerst weitere Positionen markieren.</translation>
    </message>
    <message>
        <source>&amp;Ruler	M</source>
        <translation>&amp;Lineal	M</translation>
    </message>
    <message>
        <source>&amp;Angle</source>
        <translation>&amp;Winkel</translation>
    </message>
    <message>
        <source>&amp;Tape along the bone</source>
        <translation>&amp;Maßband auf dem Knochen</translation>
    </message>
    <message>
        <source>Area of an &amp;outline</source>
        <translation>Fläche eines &amp;Umrisses</translation>
    </message>
    <message>
        <source>&amp;Values within 5 mm of a position</source>
        <translation>We&amp;rte im Umkreis von 5 mm</translation>
    </message>
    <message>
        <source>&amp;Measure</source>
        <translation>&amp;Messen</translation>
    </message>
    <message>
        <source>&amp;Clear the measurements</source>
        <translation>Messungen lös&amp;chen</translation>
    </message>
    <message>
        <source>&amp;File</source>
        <translation>&amp;Datei</translation>
    </message>
    <message>
        <source>&amp;Open a DICOM folder or a case ...</source>
        <translation>DICOM-Ordner oder Fall ö&amp;ffnen ...</translation>
    </message>
    <message>
        <source>Open a DICOM folder or a case</source>
        <translation>DICOM-Ordner oder Fall öffnen</translation>
    </message>
    <message>
        <source>Open a &amp;file ...</source>
        <translation>Da&amp;tei öffnen ...</translation>
    </message>
    <message>
        <source>Open a scan</source>
        <translation>Aufnahme öffnen</translation>
    </message>
    <message>
        <source>&amp;Add a scan to touch ...</source>
        <translation>Aufnahme zum Tasten &amp;hinzufügen ...</translation>
    </message>
    <message>
        <source>Add a scan at the position that its file states</source>
        <translation>Eine Aufnahme an der in ihrer Datei angegebenen Position hinzufügen</translation>
    </message>
    <message>
        <source>Shape of the added scan</source>
        <translation>Form der hinzugefügten Aufnahme</translation>
    </message>
    <message>
        <source>A threshold: 300 (from 300 up); a range: 100:400; or the name of a label.
Leave it empty for the default shape of such a scan or case.</source>
        <translation>Ein Schwellenwert: 300 (ab 300); ein Bereich: 100:400; oder der Name eines Labels.
Leer lassen für die übliche Form einer solchen Aufnahme.</translation>
    </message>
    <message>
        <source>Open the built-in &amp;head</source>
        <translation>Eingebauten &amp;Kopf öffnen</translation>
    </message>
    <message>
        <source>Open the &amp;built-in spine</source>
        <translation>Eingebaute &amp;Wirbelsäule öffnen</translation>
    </message>
    <message>
        <source>Open a s&amp;ession to continue ...</source>
        <translation>S&amp;itzung zum Fortsetzen öffnen ...</translation>
    </message>
    <message>
        <source>Open a session</source>
        <translation>Sitzung öffnen</translation>
    </message>
    <message>
        <source>Contin&amp;ue the interrupted session</source>
        <translation>&amp;Unterbrochene Sitzung fortsetzen</translation>
    </message>
    <message>
        <source>&amp;Watch a session ...</source>
        <translation>Sitzung an&amp;sehen ...</translation>
    </message>
    <message>
        <source>Watch a session</source>
        <translation>Sitzung ansehen</translation>
    </message>
    <message>
        <source>&amp;Save the operated volume ...</source>
        <translation>&amp;Operiertes Volumen speichern ...</translation>
    </message>
    <message>
        <source>Save the operated volume</source>
        <translation>Operiertes Volumen speichern</translation>
    </message>
    <message>
        <source>Save the &amp;mesh ...</source>
        <translation>Oberflächennet&amp;z speichern ...</translation>
    </message>
    <message>
        <source>Save the mesh</source>
        <translation>Oberflächennetz speichern</translation>
    </message>
    <message>
        <source>Save the sess&amp;ion ...</source>
        <translation>Sitzun&amp;g speichern ...</translation>
    </message>
    <message>
        <source>Save the session</source>
        <translation>Sitzung speichern</translation>
    </message>
    <message>
        <source>Make a &amp;case ...</source>
        <translation>Fall &amp;erstellen ...</translation>
    </message>
    <message>
        <source>Save the &amp;picture ...</source>
        <translation>&amp;Bild speichern ...</translation>
    </message>
    <message>
        <source>Save the picture</source>
        <translation>Bild speichern</translation>
    </message>
    <message>
        <source>&amp;Quit</source>
        <translation>Bee&amp;nden</translation>
    </message>
    <message>
        <source>&amp;Edit</source>
        <translation>&amp;Bearbeiten</translation>
    </message>
    <message>
        <source>&amp;Undo the last change</source>
        <translation>Letzte Änderung &amp;zurücknehmen</translation>
    </message>
    <message>
        <source>&amp;Redo the change</source>
        <translation>Änderung &amp;wiederholen</translation>
    </message>
    <message>
        <source>Try &amp;again from here ...</source>
        <translation>Von hier &amp;neu versuchen ...</translation>
    </message>
    <message>
        <source>&amp;Go to another branch ...</source>
        <translation>Zu einem anderen Zwei&amp;g gehen ...</translation>
    </message>
    <message>
        <source>Go to the &amp;next step</source>
        <translation>Zum nächsten &amp;Schritt gehen</translation>
    </message>
    <message>
        <source>&amp;Score of the operation ...</source>
        <translation>&amp;Bewertung der Operation ...</translation>
    </message>
    <message>
        <source>&amp;Compare with another state ...</source>
        <translation>Mit anderem Zustand &amp;vergleichen ...</translation>
    </message>
    <message>
        <source>&amp;View</source>
        <translation>&amp;Ansicht</translation>
    </message>
    <message>
        <source>&amp;Whole scan</source>
        <translation>&amp;Ganze Aufnahme</translation>
    </message>
    <message>
        <source>S&amp;tructures ...</source>
        <translation>S&amp;trukturen ...</translation>
    </message>
    <message>
        <source>&amp;Display</source>
        <translation>&amp;Anzeige</translation>
    </message>
    <message>
        <source>&amp;One picture</source>
        <translation>&amp;Ein Bild</translation>
    </message>
    <message>
        <source>&amp;Anaglyph: red and cyan glasses</source>
        <translation>&amp;Anaglyphe: rot-türkise Brille</translation>
    </message>
    <message>
        <source>&amp;Side by side: 3-D display</source>
        <translation>&amp;Nebeneinander: 3-D-Bildschirm</translation>
    </message>
    <message>
        <source>&amp;Headset (OpenXR)</source>
        <translation>&amp;Headset (OpenXR)</translation>
    </message>
    <message>
        <source>&amp;Mirrored: display seen in a mirror</source>
        <translation>&amp;Gespiegelt: Bildschirm im Spiegel betrachtet</translation>
    </message>
    <message>
        <source>&amp;Larger text</source>
        <translation>G&amp;rößere Schrift</translation>
    </message>
    <message>
        <source>S&amp;maller text</source>
        <translation>&amp;Kleinere Schrift</translation>
    </message>
    <message>
        <source>&amp;Names of the plan	N</source>
        <translation>&amp;Namen des Plans	N</translation>
    </message>
    <message>
        <source>&amp;Event log	E</source>
        <translation>&amp;Ereignisliste	E</translation>
    </message>
    <message>
        <source>&amp;Why this force?	X</source>
        <translation>&amp;Warum diese Kraft?	X</translation>
    </message>
    <message>
        <source>&amp;Sound of contact and drill</source>
        <translation>To&amp;n von Kontakt und Bohrer</translation>
    </message>
    <message>
        <source>No sound device was found. Connect one, then switch the sound on again.</source>
        <translation>Kein Tongerät gefunden. Eines anschließen, dann den Ton wieder einschalten.</translation>
    </message>
    <message>
        <source>&amp;Help</source>
        <translation>&amp;Hilfe</translation>
    </message>
    <message>
        <source>&amp;Keys and mouse</source>
        <translation>&amp;Tasten und Maus</translation>
    </message>
    <message>
        <source>&amp;About trephine</source>
        <translation>&amp;Über trephine</translation>
    </message>
    <message>
        <source>Surgical simulation on real CT and MR scans, with haptic contact.
For training and research. Not a medical device.
Licence: Apache-2.0</source>
        <translation>Chirurgische Simulation auf echten CT- und MR-Aufnahmen, mit haptischem Kontakt.
Für Ausbildung und Forschung. Kein Medizinprodukt.
Lizenz: Apache-2.0</translation>
    </message>
    <message>
        <source>&amp;Pieces</source>
        <translation>&amp;Stücke</translation>
    </message>
    <message>
        <source>&amp;Detach cut pieces</source>
        <translation>Gesägte Stücke &amp;lösen</translation>
    </message>
    <message>
        <source>&amp;Grasp or release the touched piece	T</source>
        <translation>Berührtes Stück &amp;greifen oder loslassen	T</translation>
    </message>
    <message>
        <source>&amp;Put the piece back in its place	Shift+T</source>
        <translation>Stück &amp;zurücksetzen	Umschalt+T</translation>
    </message>
    <message>
        <source>&amp;Commands</source>
        <translation>B&amp;efehle</translation>
    </message>
    <message>
        <source>%1: the touched point</source>
        <translation>%1: berührte Stelle</translation>
    </message>
    <message>
        <source>Touch a position on the bone, then press the key.</source>
        <translation>Eine Stelle des Knochens berühren, dann die Taste drücken.</translation>
    </message>
    <message>
        <source>&amp;Slices</source>
        <translation>S&amp;chichten</translation>
    </message>
    <message>
        <source>&amp;Picture alone</source>
        <translation>&amp;Nur das Bild</translation>
    </message>
    <message>
        <source>Picture and three &amp;slices</source>
        <translation>Bild und drei &amp;Schichten</translation>
    </message>
    <message>
        <source>Picture, &amp;X-ray and section</source>
        <translation>Bild, &amp;Röntgen und Schnitt</translation>
    </message>
    <message>
        <source>Picture and &amp;volume rendering</source>
        <translation>Bild und &amp;Volumenbild</translation>
    </message>
    <message>
        <source>Picture and &amp;depth images</source>
        <translation>Bild und &amp;Tiefenbilder</translation>
    </message>
    <message>
        <source>&amp;Windowing</source>
        <translation>&amp;Fensterung</translation>
    </message>
    <message>
        <source>&amp;Before and after</source>
        <translation>Vor&amp;her und nachher</translation>
    </message>
    <message>
        <source>&amp;After</source>
        <translation>&amp;Nachher</translation>
    </message>
    <message>
        <source>&amp;Before</source>
        <translation>&amp;Vorher</translation>
    </message>
    <message>
        <source>Removed matter in &amp;amber</source>
        <translation>Abgetragenes in &amp;Bernstein</translation>
    </message>
    <message>
        <source>&amp;Thickness</source>
        <translation>Schicht&amp;dicke</translation>
    </message>
    <message>
        <source>One slice</source>
        <translation>Eine Schicht</translation>
    </message>
    <message>
        <source>Mean of %1 mm</source>
        <translation>Mittel über %1 mm</translation>
    </message>
    <message>
        <source>&amp;Volume rendering</source>
        <translation>V&amp;olumenbild</translation>
    </message>
    <message>
        <source>&amp;Structures</source>
        <translation>Str&amp;ukturen</translation>
    </message>
    <message>
        <source>&amp;Use the visible values as solid</source>
        <translation>Sichtbare &amp;Werte als Festkörper verwenden</translation>
    </message>
    <message>
        <source>Outlines of the scan&apos;s &amp;labels</source>
        <translation>Umrisse der &amp;Labels</translation>
    </message>
    <message>
        <source>View from the bac&amp;k: the patient&apos;s left is on the left</source>
        <translation>&amp;Ansicht von hinten: links des Patienten ist links</translation>
    </message>
    <message>
        <source>Slices follo&amp;w the tool</source>
        <translation>Schichten folgen dem Werk&amp;zeug</translation>
    </message>
    <message>
        <source>&amp;Mark this position in the session</source>
        <translation>Diese &amp;Position in der Sitzung vermerken</translation>
    </message>
    <message>
        <source>&amp;Clip the picture at the section</source>
        <translation>&amp;Bild am Schnitt aufschneiden</translation>
    </message>
    <message>
        <source>&amp;About the scan ...</source>
        <translation>Ü&amp;ber die Aufnahme ...</translation>
    </message>
    <message>
        <source>The panes show the patient&apos;s left on the right. To mirror them: Slices &gt; View from the back.</source>
        <translation>Die Felder zeigen links des Patienten rechts. Spiegeln: Schichten &gt; Ansicht von hinten.</translation>
    </message>
    <message>
        <source>The panes show the patient&apos;s left on the left. To mirror them: Slices &gt; View from the back.</source>
        <translation>Die Felder zeigen links des Patienten links. Spiegeln: Schichten &gt; Ansicht von hinten.</translation>
    </message>
    <message>
        <source>The scan has no labels</source>
        <translation>Die Aufnahme hat keine Labels</translation>
    </message>
    <message>
        <source>&amp;Shown</source>
        <translation>&amp;Gezeigt</translation>
    </message>
    <message>
        <source>&amp;Translucent</source>
        <translation>&amp;Durchscheinend</translation>
    </message>
    <message>
        <source>&amp;Hidden</source>
        <translation>&amp;Ausgeblendet</translation>
    </message>
    <message>
        <source>The solid shape is a label or belongs to a session. Open the scan alone to choose another.</source>
        <translation>Der Festkörper ist ein Label oder gehört zu einer Sitzung. Für eine andere Wahl die Aufnahme allein öffnen.</translation>
    </message>
    <message>
        <source>The visible values are not one range. Set a range in the box Solid shape.</source>
        <translation>Die sichtbaren Werte sind kein einzelner Bereich. Im Kasten Festkörper einen Bereich einstellen.</translation>
    </message>
    <message>
        <source>The picture shows the new solid shape. Press Use to operate on it.</source>
        <translation>Das Bild zeigt den neuen Festkörper. Mit Verwenden wird daran operiert.</translation>
    </message>
    <message>
        <source>%1 x %2 x %3 voxels of %L4 x %L5 x %L6 mm
</source>
        <translation>%1 x %2 x %3 Voxel von %L4 x %L5 x %L6 mm
</translation>
    </message>
    <message>
        <source>%1 x %2 x %3 mm in all
</source>
        <translation>insgesamt %1 x %2 x %3 mm
</translation>
    </message>
    <message>
        <source>Hounsfield units
</source>
        <translation>Hounsfield-Einheiten
</translation>
    </message>
    <message>
        <source>values without a unit
</source>
        <translation>Werte ohne Einheit
</translation>
    </message>
    <message>
        <source>slices are ordered toward %1
</source>
        <translation>Schichten sind nach %1 geordnet
</translation>
    </message>
    <message>
        <source>%1 labels
</source>
        <translation>%1 Labels
</translation>
    </message>
    <message>
        <source>The scan</source>
        <translation>Die Aufnahme</translation>
    </message>
    <message>
        <source>The picture is clipped at the plane of the section. Press F7 to see, move and turn it.</source>
        <translation>Das Bild ist an der Schnittebene aufgeschnitten. F7 zeigt die Ebene zum Schieben und Drehen.</translation>
    </message>
    <message>
        <source>Tools</source>
        <translation>Werkzeuge</translation>
    </message>
    <message>
        <source>Tool</source>
        <translation>Werkzeug</translation>
    </message>
    <message>
        <source>Depth of a press below the surface  (wheel, PgUp, PgDn)</source>
        <translation>Tiefe des Drucks unter der Oberfläche  (Mausrad, Bild auf, Bild ab)</translation>
    </message>
    <message>
        <source>Press</source>
        <translation>Druck</translation>
    </message>
    <message>
        <source>Undo</source>
        <translation>Zurück</translation>
    </message>
    <message>
        <source>Undo the last change: a stroke, a command or a step  (Ctrl+Z)</source>
        <translation>Letzte Änderung zurücknehmen: einen Strich, Befehl oder Schritt  (Strg+Z)</translation>
    </message>
    <message>
        <source>Redo</source>
        <translation>Wieder</translation>
    </message>
    <message>
        <source>Redo the change  (Ctrl+Y)</source>
        <translation>Änderung wiederholen  (Strg+Y)</translation>
    </message>
    <message>
        <source>View</source>
        <translation>Ansicht</translation>
    </message>
    <message>
        <source>Front</source>
        <translation>Vorn</translation>
    </message>
    <message>
        <source>Back</source>
        <translation>Hinten</translation>
    </message>
    <message>
        <source>Left</source>
        <translation>Links</translation>
    </message>
    <message>
        <source>Right</source>
        <translation>Rechts</translation>
    </message>
    <message>
        <source>Above</source>
        <translation>Oben</translation>
    </message>
    <message>
        <source>Below</source>
        <translation>Unten</translation>
    </message>
    <message>
        <source>Not clipped</source>
        <translation>Nicht aufgeschnitten</translation>
    </message>
    <message>
        <source>Clip from the left</source>
        <translation>Von links aufschneiden</translation>
    </message>
    <message>
        <source>Clip from the front</source>
        <translation>Von vorn aufschneiden</translation>
    </message>
    <message>
        <source>Clip from above</source>
        <translation>Von oben aufschneiden</translation>
    </message>
    <message>
        <source>Clip toward the viewer</source>
        <translation>Zum Betrachter aufschneiden</translation>
    </message>
    <message>
        <source>Clip at the section</source>
        <translation>Am Schnitt aufschneiden</translation>
    </message>
    <message>
        <source>Structures</source>
        <translation>Strukturen</translation>
    </message>
    <message>
        <source>Show, hide, fade</source>
        <translation>Zeigen, ausblenden</translation>
    </message>
    <message>
        <source>Solid shape</source>
        <translation>Festkörper</translation>
    </message>
    <message>
        <source>Use</source>
        <translation>Verwenden</translation>
    </message>
    <message>
        <source>Start again from the uncut scan, with this shape</source>
        <translation>Mit dieser Form auf der unveränderten Aufnahme neu beginnen</translation>
    </message>
    <message>
        <source>Reset</source>
        <translation>Verwerfen</translation>
    </message>
    <message>
        <source>Discard the choice and show the current solid shape</source>
        <translation>Auswahl verwerfen und den jetzigen Festkörper zeigen</translation>
    </message>
    <message>
        <source>Range of values</source>
        <translation>Wertebereich</translation>
    </message>
    <message>
        <source>Skull (CT)</source>
        <translation>Schädel (CT)</translation>
    </message>
    <message>
        <source>Spine (CT)</source>
        <translation>Wirbelsäule (CT)</translation>
    </message>
    <message>
        <source>Skull: 300 HU, its largest part. Spine: 150 HU, without small parts.</source>
        <translation>Schädel: 300 HU, größter Teil. Wirbelsäule: 150 HU, ohne kleine Teile.</translation>
    </message>
    <message>
        <source>Largest part only</source>
        <translation>Nur größter Teil</translation>
    </message>
    <message>
        <source>Omit disconnected parts, such as a table or a head holder</source>
        <translation>Getrennte Teile weglassen, etwa einen Tisch oder Kopfhalter</translation>
    </message>
    <message>
        <source>from</source>
        <translation>von</translation>
    </message>
    <message>
        <source>to</source>
        <translation>bis</translation>
    </message>
    <message>
        <source>F1: keys and mouse</source>
        <translation>F1: Tasten und Maus</translation>
    </message>
    <message>
        <source>History</source>
        <translation>Verlauf</translation>
    </message>
    <message>
        <source>Undo and redo changes</source>
        <translation>Änderungen zurücknehmen und wiederholen</translation>
    </message>
    <message>
        <source>Compare ...</source>
        <translation>Vergleich ...</translation>
    </message>
    <message>
        <source>Compare this state with another one  (Ctrl+D)</source>
        <translation>Diesen Zustand mit einem anderen vergleichen  (Strg+D)</translation>
    </message>
    <message>
        <source>change %1 of %2</source>
        <translation>Änderung %1 von %2</translation>
    </message>
    <message>
        <source>%1 on %2</source>
        <translation>%1 auf %2</translation>
    </message>
    <message>
        <source>Compare</source>
        <translation>Vergleich</translation>
    </message>
    <message>
        <source>...</source>
        <translation>...</translation>
    </message>
    <message>
        <source>This session cannot be continued from here</source>
        <translation>Diese Sitzung kann von hier nicht fortgesetzt werden</translation>
    </message>
    <message>
        <source>A session of several hands cannot be continued</source>
        <translation>Eine Sitzung mehrerer Hände kann nicht fortgesetzt werden</translation>
    </message>
    <message>
        <source>Note: %1</source>
        <translation>Notiz: %1</translation>
    </message>
    <message>
        <source>Replay at %1 Hz</source>
        <translation>Wiedergabe mit %1 Hz</translation>
    </message>
    <message>
        <source>⚠ the force was off at this time</source>
        <translation>⚠ die Kraft war in diesem Augenblick aus</translation>
    </message>
    <message>
        <source>This is the last step.</source>
        <translation>Dies ist der letzte Schritt.</translation>
    </message>
    <message>
        <source>The next step, &quot;%1&quot;, begins by itself when its conditions are met.</source>
        <translation>Der nächste Schritt, „%1“, beginnt von selbst, wenn seine Bedingungen erfüllt sind.</translation>
    </message>
    <message>
        <source>This operation is not recorded, so there is no score. Start it from the simulator, or record it (option record FILE).</source>
        <translation>Diese Operation wird nicht aufgezeichnet, daher gibt es keine Bewertung. Aus dem Simulator starten oder aufzeichnen (Option record FILE).</translation>
    </message>
    <message>
        <source>Sessions (*.session);;All files (*)</source>
        <translation>Sitzungen (*.session);;Alle Dateien (*)</translation>
    </message>
    <message>
        <source>Scans (*.mha *.mhd *.nrrd *.nhdr *.nii *.nii.gz *.dcm);;All files (*)</source>
        <translation>Aufnahmen (*.mha *.mhd *.nrrd *.nhdr *.nii *.nii.gz *.dcm);;Alle Dateien (*)</translation>
    </message>
    <message>
        <source>Volumes (*.mha *.nrrd *.nii.gz *.nii)</source>
        <translation>Volumen (*.mha *.nrrd *.nii.gz *.nii)</translation>
    </message>
    <message>
        <source>Meshes (*.stl *.ply *.obj *.vtp)</source>
        <translation>Netze (*.stl *.ply *.obj *.vtp)</translation>
    </message>
    <message>
        <source>Sessions (*.session)</source>
        <translation>Sitzungen (*.session)</translation>
    </message>
    <message>
        <source>Pictures (*.png)</source>
        <translation>Bilder (*.png)</translation>
    </message>
    <message>
        <source>Hand whose tool is shown here</source>
        <translation>Hand, deren Werkzeug hier gezeigt wird</translation>
    </message>
    <message>
        <source>Right hand</source>
        <translation>Rechte Hand</translation>
    </message>
    <message>
        <source>Left hand</source>
        <translation>Linke Hand</translation>
    </message>
    <message>
        <source>Wor&amp;kspace of the device</source>
        <translation>&amp;Arbeitsbereich des Geräts</translation>
    </message>
    <message>
        <source>The device reports no workspace.</source>
        <translation>Das Gerät meldet keinen Arbeitsbereich.</translation>
    </message>
    <message>
        <source>replaying the session up to this time ...</source>
        <translation>die Sitzung wird bis zu dieser Zeit abgespielt ...</translation>
    </message>
</context>
<context>
    <name>trephine::view::ReplayPanel</name>
    <message>
        <source>Session</source>
        <translation>Sitzung</translation>
    </message>
    <message>
        <source>Pause</source>
        <translation>Pause</translation>
    </message>
    <message>
        <source>Space</source>
        <translation>Leertaste</translation>
    </message>
    <message>
        <source>Note ...</source>
        <translation>Notiz ...</translation>
    </message>
    <message>
        <source>Add or edit a note at this time  (Ctrl+N)</source>
        <translation>Notiz zu diesem Zeitpunkt hinzufügen oder ändern  (Strg+N)</translation>
    </message>
    <message>
        <source>Operate from here</source>
        <translation>Von hier operieren</translation>
    </message>
    <message>
        <source>Continue the operation from this moment, in a new session</source>
        <translation>Die Operation von diesem Augenblick an in einer neuen Sitzung fortsetzen</translation>
    </message>
    <message>
        <source>Play</source>
        <translation>Abspielen</translation>
    </message>
    <message>
        <source>Note: %1</source>
        <translation>Notiz: %1</translation>
    </message>
    <message>
        <source>Note</source>
        <translation>Notiz</translation>
    </message>
    <message>
        <source>Note at %L1 s. An empty text removes it.</source>
        <translation>Notiz bei %L1 s. Ein leerer Text entfernt sie.</translation>
    </message>
    <message>
        <source>Note at %L1 s:</source>
        <translation>Notiz bei %L1 s:</translation>
    </message>
    <message>
        <source>going to %1 ...</source>
        <translation>Sprung zu %1 ...</translation>
    </message>
</context>
<context>
    <name>trephine::view::ScoreDialog</name>
    <message>
        <source>Verdict</source>
        <translation>Urteil</translation>
    </message>
    <message>
        <source>Finding</source>
        <translation>Befund</translation>
    </message>
    <message>
        <source>Value</source>
        <translation>Wert</translation>
    </message>
    <message>
        <source>Limits</source>
        <translation>Grenzen</translation>
    </message>
    <message>
        <source>Points</source>
        <translation>Punkte</translation>
    </message>
    <message>
        <source>Reason</source>
        <translation>Grund</translation>
    </message>
    <message>
        <source>Reported without verdict</source>
        <translation>Ohne Urteil berichtet</translation>
    </message>
    <message>
        <source>Write the report ...</source>
        <translation>Bericht schreiben ...</translation>
    </message>
    <message>
        <source>Score of the operation</source>
        <translation>Bewertung der Operation</translation>
    </message>
    <message>
        <source>The recording could not be copied. Free disk space, then try again.</source>
        <translation>Die Aufzeichnung konnte nicht kopiert werden. Speicherplatz freigeben und erneut versuchen.</translation>
    </message>
    <message>
        <source>Judging the operation so far ...</source>
        <translation>Die bisherige Operation wird bewertet ...</translation>
    </message>
    <message>
        <source>Writing the report ...</source>
        <translation>Bericht wird geschrieben ...</translation>
    </message>
    <message>
        <source>Write the report</source>
        <translation>Bericht schreiben</translation>
    </message>
    <message>
        <source>Pages (*.html)</source>
        <translation>Seiten (*.html)</translation>
    </message>
    <message>
        <source>The report was written. Open it in a browser: &lt;a href=&quot;%1&quot;&gt;%2&lt;/a&gt;</source>
        <translation>Der Bericht ist geschrieben. Im Browser öffnen: &lt;a href=&quot;%1&quot;&gt;%2&lt;/a&gt;</translation>
    </message>
    <message>
        <source>■ %1. Points of other findings do not compensate for a critical one.</source>
        <translation>■ %1. Punkte anderer Befunde gleichen einen kritischen nicht aus.</translation>
    </message>
    <message>
        <source>Findings with %1 further points could not be judged; the column Reason explains why.</source>
        <translation>Befunde mit weiteren %1 Punkten konnten nicht beurteilt werden; die Spalte Grund erklärt es.</translation>
    </message>
    <message>
        <source>Limits and weights are those of the case and its procedure.</source>
        <translation>Grenzen und Gewichte sind die des Falls und seines Eingriffs.</translation>
    </message>
    <message>
        <source>The report was written: %1</source>
        <translation>Der Bericht ist geschrieben: %1</translation>
    </message>
    <message>
        <source>The report was not written: %1</source>
        <translation>Der Bericht wurde nicht geschrieben: %1</translation>
    </message>
    <message>
        <source>Preliminary: the recording is being verified, and the motion of the hands measured.</source>
        <translation>Vorläufig: die Aufzeichnung wird geprüft, und die Bewegung der Hände wird gemessen.</translation>
    </message>
</context>
<context>
    <name>trephine::view::StartPage</name>
    <message>
        <source>trephine simulator</source>
        <translation>trephine Simulator</translation>
    </message>
    <message>
        <source>Choose an operation</source>
        <translation>Operation wählen</translation>
    </message>
    <message>
        <source>Your own scan</source>
        <translation>Eigene Aufnahme</translation>
    </message>
    <message>
        <source>Open a DICOM folder, a case, or a file. Choose a procedure, or operate freely.</source>
        <translation>DICOM-Ordner, Fall oder Datei öffnen. Einen Eingriff wählen oder frei operieren.</translation>
    </message>
    <message>
        <source>Procedure</source>
        <translation>Eingriff</translation>
    </message>
    <message>
        <source>No steps, or those of the case</source>
        <translation>Keine Schritte, oder die des Falls</translation>
    </message>
    <message>
        <source>Open a folder ...</source>
        <translation>Ordner öffnen ...</translation>
    </message>
    <message>
        <source>Open a DICOM folder or a case</source>
        <translation>DICOM-Ordner oder Fall öffnen</translation>
    </message>
    <message>
        <source>Open a file ...</source>
        <translation>Datei öffnen ...</translation>
    </message>
    <message>
        <source>Open a scan</source>
        <translation>Aufnahme öffnen</translation>
    </message>
    <message>
        <source>The recording &quot;%1&quot; does not contain its scan. Select the scan that was operated on.</source>
        <translation>Die Aufnahme „%1“ enthält ihren Scan nicht. Wählen Sie den Scan, an dem operiert wurde.</translation>
    </message>
    <message>
        <source>Select a folder ...</source>
        <translation>Ordner wählen ...</translation>
    </message>
    <message>
        <source>Select a file ...</source>
        <translation>Datei wählen ...</translation>
    </message>
    <message>
        <source>Your operations</source>
        <translation>Ihre Operationen</translation>
    </message>
    <message>
        <source>Operations in which something was changed are kept here.</source>
        <translation>Operationen, in denen etwas verändert wurde, werden hier aufbewahrt.</translation>
    </message>
    <message>
        <source>%1    %2    %3</source>
        <translation>%1    %2    %3</translation>
    </message>
    <message>
        <source>    (interrupted)</source>
        <translation>    (unterbrochen)</translation>
    </message>
    <message>
        <source>Continue</source>
        <translation>Fortsetzen</translation>
    </message>
    <message>
        <source>Watch</source>
        <translation>Ansehen</translation>
    </message>
    <message>
        <source>Opening: %1 ...</source>
        <translation>Wird geöffnet: %1 ...</translation>
    </message>
    <message>
        <source>your scan</source>
        <translation>Ihre Aufnahme</translation>
    </message>
</context>
<context>
    <name>trephine::view::StepsPanel</name>
    <message>
        <source>Steps</source>
        <translation>Schritte</translation>
    </message>
    <message>
        <source>Teaching note</source>
        <translation>Lehrhinweis</translation>
    </message>
    <message>
        <source>That step does not allow the tool in the hand: the tool is removed when you go on.</source>
        <translation>Jener Schritt erlaubt das Werkzeug in der Hand nicht: Es wird beim Weitergehen abgelegt.</translation>
    </message>
    <message>
        <source>Current step: %1</source>
        <translation>Jetziger Schritt: %1</translation>
    </message>
    <message>
        <source>Done: %1</source>
        <translation>Erledigt: %1</translation>
    </message>
    <message>
        <source>Later: %1</source>
        <translation>Später: %1</translation>
    </message>
    <message>
        <source>Step %1 of %2: %3</source>
        <translation>Schritt %1 von %2: %3</translation>
    </message>
    <message>
        <source>Back: %1</source>
        <translation>Zurück: %1</translation>
    </message>
    <message>
        <source>Next: %1</source>
        <translation>Weiter: %1</translation>
    </message>
    <message>
        <source>Ctrl+Enter: the first step that is possible</source>
        <translation>Strg+Eingabe: der erste mögliche Schritt</translation>
    </message>
    <message>
        <source>Show the score</source>
        <translation>Bewertung zeigen</translation>
    </message>
    <message>
        <source>None of these steps allows the tool in the hand: it is removed when you go on.</source>
        <translation>Keiner dieser Schritte erlaubt das Instrument in der Hand: Es wird abgelegt, wenn Sie fortfahren.</translation>
    </message>
</context>
<context>
    <name>trephine::view::StructurePanel</name>
    <message>
        <source>Bone</source>
        <translation>Knochen</translation>
    </message>
    <message>
        <source>Show or hide this structure in the picture. The tool still touches the same structures.</source>
        <translation>Diese Struktur im Bild zeigen oder ausblenden. Das Werkzeug berührt weiterhin dieselben Strukturen.</translation>
    </message>
    <message>
        <source>Opacity: %1 %</source>
        <translation>Deckkraft: %1 %</translation>
    </message>
</context>
<context>
    <name>trephine::view::ToolPanel</name>
    <message>
        <source>No tool</source>
        <translation>Kein Werkzeug</translation>
    </message>
</context>
</TS>
