/** The German words of the dialog in which results are saved, and of errors, see de.js. @module */

export const saving = {
  Save: 'Speichern',
  'Save…': 'Speichern…',
  'Video quality': 'Videoqualität',
  Small: 'Klein',
  Medium: 'Mittel',
  Fine: 'Fein',
  Finest: 'Feinst',
  'Keep the sound': 'Ton behalten',
  Saving: 'Speichern',
  'Share…': 'Teilen…',
  Copy: 'Kopieren',
  'Copy a link with these settings': 'Link mit diesen Einstellungen kopieren',
  'What it takes to get the same result again': 'Was nötig ist, um dasselbe Ergebnis wieder zu erhalten',
  Recipe: 'Rezept',
  'As the source': 'Wie das Original',
  'Half of it': 'Die Hälfte davon',
  'As computed': 'Wie berechnet',
  'Other…': 'Andere…',
  'a video takes roughly {0}': 'ein Video braucht ungefähr {0}',
  '{0}, as it is.': '{0}, unverändert.',
  '{0}, as it is. {1} cannot hold it: such files are silent.':
    '{0}, unverändert. {1} kann ihn nicht aufnehmen: Solche Dateien sind stumm.',
  'No object': 'kein Objekt',
  '{0} of {1} is kept: what is saved has no other.': 'Behalten: {0} (insgesamt {1}). Gespeichert wird nichts anderes.',
  '{0} of {1} are kept: what is saved has no other.': 'Behalten: {0} (insgesamt {1}). Gespeichert wird nichts anderes.',
  '{0} of 1 frame': '{0} von 1 Bild',
  '{0} of {1} frames': '{0} von {1} Bildern',
  'Making {0}…': '{0} wird erstellt…',
  'Saved {0}, {1}.': '{0} gespeichert, {1}.',
  'Cancelled; nothing was saved.': 'Abgebrochen; nichts wurde gespeichert.',
  'Sharing did not work here; the file is saved.': 'Das Teilen ging hier nicht; die Datei ist gespeichert.',
  'The link is on the clipboard.': 'Der Link ist in der Zwischenablage.',
  'The recipe is on the clipboard.': 'Das Rezept ist in der Zwischenablage.',
  'The browser does not let the page write to the clipboard. Copy it yourself: {0}':
    'Der Browser lässt die Seite nicht in die Zwischenablage schreiben. Bitte von Hand kopieren: {0}',
  'Overlay video': 'Überlagertes Video',
  'The clip with the masks drawn over it.': 'Der Clip mit den Masken darüber.',
  'Cut-out video': 'Freisteller als Video',
  'The objects alone, for an editor, on the ground of the view “Cut-out”. MP4 cannot be transparent: it is green then.':
    'Nur die Objekte, für ein Schnittprogramm, auf dem Grund der Ansicht „Freisteller“. MP4 kann nicht transparent sein: Dann ist es grün.',
  'Cut-out pictures': 'Freisteller als Bilder',
  'The objects alone on nothing, for editors that want pictures. An animated PNG plays in browsers and chats as a GIF does.':
    'Nur die Objekte auf nichts, für Schnittprogramme, die Bilder wollen. Ein animiertes PNG läuft in Browsern und Chats wie ein GIF.',
  'ZIP of PNG files': 'ZIP mit PNG-Dateien',
  'Animated PNG': 'Animiertes PNG',
  'Alpha alone, ZIP': 'Nur Alpha, ZIP',
  'Mask video': 'Masken als Video',
  'White where objects are, black elsewhere, grey in between: a track matte for an editor.':
    'Weiß, wo Objekte sind, sonst schwarz, dazwischen grau: eine Maske für ein Schnittprogramm.',
  'Masks of all frames': 'Masken aller Bilder',
  'A ZIP of PNG files in the colours of the page, or a folder of black and white ones for each object. Times are in masks.json.':
    'Ein ZIP mit PNG-Dateien in den Farben der Seite, oder je Objekt ein Ordner mit schwarz-weißen. Die Zeiten stehen in masks.json.',
  'ZIP, in colours': 'ZIP, in Farben',
  'ZIP, by object': 'ZIP, je Objekt',
  'Mask of this frame': 'Maske dieses Bildes',
  'One PNG in the colours of the page.': 'Ein PNG in den Farben der Seite.',
  'Mask of this frame as PNG': 'Maske dieses Bildes als PNG',
  'The scene without any of the objects, for an editor: other frames show what is behind them. What none of them shows is transparent.':
    'Die Szene ganz ohne die Objekte, für ein Schnittprogramm: Andere Bilder zeigen, was dahinter ist. Was keines zeigt, ist transparent.',
  'Background of this frame as PNG': 'Hintergrund dieses Bildes als PNG',
  'ZIP, all frames': 'ZIP, alle Bilder',
  Data: 'Daten',
  'COCO run lengths for annotation tools; a table of objects; trajectories with their labels for the Moseg benchmark.':
    'COCO-Lauflängen für Programme zum Annotieren; eine Tabelle der Objekte; Trajektorien mit ihren Nummern für den Moseg-Benchmark.',
  'objects.csv: place, size and motion of the objects in each frame':
    'objects.csv: Ort, Größe und Bewegung der Objekte in jedem Bild',
  Project: 'Projekt',
  'Masks, corrections and the clip itself in one file, which this page opens again.':
    'Masken, Korrekturen und der Clip selbst in einer Datei, die diese Seite wieder öffnet.',
  'Project file': 'Projektdatei',
};

export const errors = {
  'Open another file…': 'Andere Datei öffnen…',
  'Show the sample': 'Das Beispiel zeigen',
  'This file cannot be played as a video here': 'Diese Datei lässt sich hier nicht als Video abspielen',
  'The browser has no decoder for it, or the file is damaged. Convert it to MP4 (H.264) or WebM, or try another browser.':
    'Der Browser hat keinen Decoder dafür, oder die Datei ist beschädigt. In MP4 (H.264) oder WebM umwandeln oder einen anderen Browser versuchen.',
  'One of these images cannot be read': 'Eines dieser Bilder lässt sich nicht lesen',
  'Use whole PNG, JPEG, WebP or GIF files, and leave the damaged one out.':
    'Vollständige PNG-, JPEG-, WebP- oder GIF-Dateien verwenden und die beschädigte weglassen.',
  'This is neither a video nor an image': 'Das ist weder ein Video noch ein Bild',
  'Open a video (MP4, WebM, …), an animated GIF, several images of one sequence, or one image.':
    'Ein Video (MP4, WebM, …), ein animiertes GIF, mehrere Bilder einer Folge oder ein einzelnes Bild öffnen.',
  'These files do not go together': 'Diese Dateien gehören nicht zusammen',
  'Open one video, or several images of one sequence, but not both.':
    'Ein Video öffnen oder mehrere Bilder einer Folge, aber nicht beides.',
  'The clip gives other frames than before': 'Der Clip liefert andere Bilder als vorher',
  'Run it again, then save it.': 'Neu berechnen, dann speichern.',
  'There is only one frame': 'Es gibt nur ein Bild',
  'Motion needs at least two pictures of the same scene. Open a longer video, or choose all images of a sequence.':
    'Bewegung braucht mindestens zwei Bilder derselben Szene. Ein längeres Video öffnen oder alle Bilder einer Folge wählen.',
  'This browser cannot take animated images apart': 'Dieser Browser kann bewegte Bilder nicht zerlegen',
  'Convert it to MP4 (H.264) or WebM, or open its frames as images.':
    'In MP4 (H.264) oder WebM umwandeln oder die Bilder einzeln öffnen.',
  'These images differ in size': 'Diese Bilder sind verschieden groß',
  '{0} is {1}, the first is {2}': '{0} hat {1}, das erste Bild {2}',
  'All images of a sequence must have the same width and height. Leave out the ones that differ.':
    'Alle Bilder einer Folge müssen gleich breit und gleich hoch sein. Abweichende weglassen.',
  'This is no project of TraceCut': 'Das ist kein Projekt von TraceCut',
  'Open the video itself, or a file that was saved here as a project.':
    'Das Video selbst öffnen oder eine Datei, die hier als Projekt gespeichert wurde.',
  'The clip is too large to keep': 'Der Clip ist zu groß, um ihn aufzubewahren',
  'Save the project as a file before you leave.': 'Das Projekt vor dem Verlassen als Datei speichern.',
  'No frame could be read': 'Kein Bild ließ sich lesen',
  'Choose an earlier start, or convert the video to MP4 (H.264) or WebM.':
    'Einen früheren Anfang wählen oder das Video in MP4 (H.264) oder WebM umwandeln.',
  'The video stopped answering': 'Das Video antwortet nicht mehr',
  'The browser did not reach one of the frames in 15 seconds. Try a shorter part, or convert the video to MP4 (H.264).':
    'Der Browser hat eines der Bilder in 15 Sekunden nicht erreicht. Einen kürzeren Teil versuchen oder das Video in MP4 (H.264) umwandeln.',
  'This browser is too old for TraceCut': 'Dieser Browser ist zu alt für TraceCut',
  'It needs WebAssembly with SIMD: Chrome or Edge 91, Firefox 89, Safari 16.4, or newer.':
    'Nötig ist WebAssembly mit SIMD: Chrome oder Edge 91, Firefox 89, Safari 16.4 oder neuer.',
  'The segmentation code did not load': 'Das Programm zum Segmentieren wurde nicht geladen',
  'Reload the page. If that does not help, the site is incomplete: the folder “dist” must lie beside the page.':
    'Die Seite neu laden. Wenn das nicht hilft, ist sie unvollständig: Der Ordner „dist“ muss neben der Seite liegen.',
  'There are too few frames': 'Es sind zu wenige Bilder',
  'Motion needs at least two pictures of the same scene. Choose more frames, or an earlier start.':
    'Bewegung braucht mindestens zwei Bilder derselben Szene. Mehr Bilder oder einen früheren Anfang wählen.',
  'There is more than can be processed at once': 'Das ist mehr, als auf einmal verarbeitet werden kann',
  'Choose fewer frames, or smaller pictures.': 'Wähle weniger Bilder oder kleinere.',
  'These frames have a size that cannot be processed': 'Bilder dieser Größe lassen sich nicht verarbeiten',
  'Choose another working size under “Clip”.': 'Unter „Clip“ eine andere Größe wählen.',
  'The frames change size on the way': 'Die Bilder ändern unterwegs ihre Größe',
  'Use a video or images of one size.': 'Ein Video oder Bilder einer einzigen Größe verwenden.',
  'A setting has a value that does not work': 'Eine Einstellung hat einen Wert, mit dem es nicht geht',
  'Reset it under “Settings”, then run again.': 'Unter „Einstellungen“ zurücksetzen, dann neu berechnen.',
  'The computation met values that it cannot use': 'Die Berechnung stieß auf Werte, mit denen sie nicht rechnen kann',
  'Reset the settings, or choose other frames, and run again.':
    'Die Einstellungen zurücksetzen oder andere Bilder wählen und neu berechnen.',
  'Something was asked for that is not there any more': 'Etwas wurde verlangt, das nicht mehr da ist',
  'Run it again.': 'Neu berechnen.',
  'Something else is still under way': 'Etwas anderes läuft noch',
  'Wait a moment, then run it again.': 'Einen Moment warten, dann neu berechnen.',
  'The run was ended': 'Die Berechnung wurde beendet',
  'A frame is incomplete': 'Ein Bild ist unvollständig',
  'Convert the video to MP4 (H.264) or WebM, or choose other frames.':
    'Das Video in MP4 (H.264) oder WebM umwandeln oder andere Bilder wählen.',
  'A file cannot be decoded': 'Eine Datei lässt sich nicht dekodieren',
  'Use whole PNG or JPEG files.': 'Vollständige PNG- oder JPEG-Dateien verwenden.',
  'This browser cannot decode this video': 'Dieser Browser kann dieses Video nicht dekodieren',
  'Convert it to MP4 (H.264) or WebM, or try another browser.':
    'In MP4 (H.264) oder WebM umwandeln oder einen anderen Browser versuchen.',
  'There is no picture in this file': 'In dieser Datei ist kein Bild',
  'Open a video file: MP4, WebM, MOV or MKV.': 'Eine Videodatei öffnen: MP4, WebM, MOV oder MKV.',
  'This file is cut off or damaged': 'Diese Datei ist abgeschnitten oder beschädigt',
  'Choose frames before the damage, or copy or convert the file again.':
    'Bilder vor der Beschädigung wählen oder die Datei noch einmal kopieren oder umwandeln.',
  'The file cannot be read': 'Die Datei lässt sich nicht lesen',
  'Copy it to this device, and open it again.': 'Auf dieses Gerät kopieren und noch einmal öffnen.',
  'The camera may not be used': 'Die Kamera darf nicht benutzt werden',
  'Allow it for this page in the browser’s address bar, then open this again.':
    'In der Adressleiste des Browsers für diese Seite erlauben, dann noch einmal öffnen.',
  'There is no camera': 'Es gibt keine Kamera',
  'Connect one and open this again, or open a video file instead.':
    'Eine anschließen und noch einmal öffnen, oder stattdessen eine Videodatei öffnen.',
  'The camera gives no picture': 'Die Kamera liefert kein Bild',
  'Close whatever else uses it, then open this again.': 'Schließen, was sie sonst benutzt, dann noch einmal öffnen.',
  'This browser cannot record here': 'Dieser Browser kann hier nicht aufnehmen',
  'Open the page over https or from localhost, or open a video file instead.':
    'Die Seite über https oder von localhost öffnen, oder stattdessen eine Videodatei öffnen.',
  'The clip was not segmented to its end': 'Der Clip wurde nicht bis zum Ende segmentiert',
  'Run it again, to the end.': 'Neu berechnen, bis zum Ende.',
  'The computation broke down': 'Die Berechnung ist zusammengebrochen',
  'Run it again; if it happens again, choose fewer frames or a smaller working size. Other clips are not affected.':
    'Neu berechnen; wenn es wieder geschieht, weniger Bilder oder eine kleinere Größe wählen. Andere Clips sind nicht betroffen.',
  'The computation ran out of memory': 'Der Berechnung ging der Speicher aus',
  'Choose fewer frames or a smaller working size under “Clip”.':
    'Unter „Clip“ weniger Bilder oder eine kleinere Größe wählen.',
  'The network does not answer, so this could not be opened. Please try again.':
    'Das Netz antwortet nicht, darum ließ sich das nicht öffnen. Bitte noch einmal versuchen.',
  About: 'Über TraceCut',
  'TraceCut {0}, free software under the MIT or Apache licence.':
    'TraceCut {0}, freie Software unter der MIT- oder der Apache-Lizenz.',
  'The same clip gives the same result in every browser, to the last bit. This browser is checked by computing made clips, which takes some seconds; each line below is then a part of the program and what it came to.':
    'Derselbe Clip ergibt in jedem Browser dasselbe, bis zum letzten Bit. Dieser Browser wird geprüft, indem er gemachte Clips berechnet, was einige Sekunden dauert; jede Zeile unten ist dann ein Teil des Programms und was bei ihm herauskam.',
  'What is promised': 'Was versprochen ist',
  'Check this browser': 'Diesen Browser prüfen',
  'Checking…': 'Wird geprüft …',
  'the same': 'dasselbe',
  'differs from {0}': 'anders als {0}',
  'All {0} parts came to what they come to everywhere.': 'Bei allen {0} Teilen kam heraus, was überall herauskommt.',
  '{0} of {1} parts came to something else: please report this browser, its version and this list.':
    'Bei {0} von {1} Teilen kam etwas anderes heraus: bitte diesen Browser, seine Version und diese Liste melden.',
  'Something went wrong': 'Etwas ist schiefgegangen',
  'Run it again, or open the sample. The browser’s console has the details.':
    'Neu berechnen oder das Beispiel öffnen. Die Konsole des Browsers hat die Einzelheiten.',
  'frame {0} is at {1} s and was at {2} s': 'Bild {0} liegt bei {1} s und lag bei {2} s',
};
