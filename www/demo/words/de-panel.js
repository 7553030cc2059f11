/** The German words of the panel beside the picture, see de.js. @module */

export const objects = {
  Objects: 'Objekte',
  'Keep all': 'Alle behalten',
  Keep: 'Behalten',
  'Keep {0}': '{0} behalten',
  'Keep it on screen, and in what is saved': 'Auf dem Bildschirm behalten und beim Speichern',
  'Show {0} alone': 'Nur {0} zeigen',
  'Hide {0}': '{0} ausblenden',
  'Show {0}': '{0} einblenden',
  Hide: 'Ausblenden',
  Show: 'Zeigen',
  'not seen': 'nicht zu sehen',
  'When each object is there': 'Wann jedes Objekt da ist',
  '{0}; go to where it is largest, {1}': '{0}; zum Bild gehen, in dem es am größten ist, {1}',
};

export const edges = {
  Edges: 'Kanten',
  Reset: 'Zurücksetzen',
  Grow: 'Wachsen',
  Feather: 'Weich',
  Specks: 'Flecken',
  Smooth: 'Glätten',
  'Smooth over time': 'Über die Zeit glätten',
  kept: 'bleiben',
  'as found': 'gar nicht',
  hard: 'hart',
  on: 'an',
  off: 'aus',
  'Of all masks, on screen and in what is saved. Specks are pieces up to that part of the frame: they are left out. Smoothed masks are those that most frames before and after agree on, along the motion.':
    'Aller Masken, auf dem Bildschirm und beim Speichern. Flecken sind Stücke bis zu diesem Teil des Bildes: Sie entfallen. Geglättete Masken sind die, bei denen die meisten Bilder davor und danach übereinstimmen, entlang der Bewegung.',
};

export const layers = {
  Picture: 'Bild',
  'How it works: what each stage sees': 'Wie es geht: was jeder Schritt sieht',
  Key: 'Taste',
  Opacity: 'Deckkraft',
  Fill: 'Füllung',
  Trail: 'Spur',
  none: 'keine',
  Tint: 'Tönung',
  Pixels: 'Pixel',
  Links: 'Verbindungen',
  Above: 'Ab',
  background: 'Hintergrund',
  'objects, colours as listed': 'Objekte, Farben wie in der Liste',
  'Every pixel that belongs to an object, in its colour.': 'Jedes Pixel, das zu einem Objekt gehört, in dessen Farbe.',
  'Source image': 'Originalbild',
  'The frame itself, a little pale so that the layers stand out.':
    'Das Bild selbst, etwas blass, damit die Ebenen hervortreten.',
  'Points followed from frame to frame, coloured by object. Pixels are tinted like the nearest point.':
    'Punkte, von Bild zu Bild verfolgt, in der Farbe ihres Objekts. Pixel sind wie der nächste Punkt getönt.',
  'Mean colour': 'Mittlere Farbe',
  'Pieces of the frame that lie between its contours, gaps bridged; each belongs to one object.':
    'Stücke des Bildes zwischen seinen Konturen, Lücken überbrückt; jedes gehört zu einem Objekt.',
  'Deleted edges': 'Gelöschte Kanten',
  'Lines fitted to the contours, and the Gabriel edges that bridge the gaps between them.':
    'Linien entlang der Konturen, und die Gabriel-Kanten, die Lücken zwischen ihnen überbrücken.',
  contours: 'Konturen',
  'Gabriel edges': 'Gabriel-Kanten',
  'Delaunay edges deleted': 'gelöschte Delaunay-Kanten',
  'Boundaries (Pb)': 'Grenzen (Pb)',
  'Ridges only': 'Nur Grate',
  'How likely each pixel lies on a boundary, from brightness, colour and texture; computed when first shown.':
    'Wie wahrscheinlich jedes Pixel auf einer Grenze liegt, aus Helligkeit, Farbe und Textur; beim ersten Zeigen berechnet.',
  'Neighbouring points whose motions part: there an object ends.':
    'Benachbarte Punkte, deren Bewegungen auseinandergehen: Dort endet ein Objekt.',
  'motions part': 'Bewegungen gehen auseinander',
  'neighbours that move alike': 'Nachbarn, die sich gleich bewegen',
  'Embedding colours': 'Farben der Einbettung',
  'Points of like colour have moved alike over their whole life.':
    'Punkte ähnlicher Farbe haben sich ihr Leben lang ähnlich bewegt.',
  'eigenvectors 2, 3 and 4': 'Eigenvektoren 2, 3 und 4',
  'Where each pixel goes in the next frame; computed when first shown.':
    'Wohin jedes Pixel im nächsten Bild geht; beim ersten Zeigen berechnet.',
  'Hue: direction. White: no motion.': 'Farbton: Richtung. Weiß: keine Bewegung.',
  'Full colour: fast.': 'Volle Farbe: schnell.',
  'Full colour: {0} px per frame.': 'Volle Farbe: {0} px je Bild.',
  'Colour wheel of motion': 'Farbkreis der Bewegung',
  Foreground: 'Vordergrund',
  'Trajectories that stand out enough, among those that move like them, to be part of something that moves.':
    'Trajektorien, die unter denen, die sich wie sie bewegen, genug hervorstechen, um Teil von etwas Bewegtem zu sein.',
  'all others': 'alle anderen',
  foreground: 'Vordergrund',
  'foreground, {0} of {1}': 'Vordergrund, {0} von {1}',
  'not foreground': 'kein Vordergrund',
  'Trajectories in context (s̄)': 'Trajektorien im Umfeld (s̄)',
  'How much the motion of a pixel, or of a trajectory in all its life, stands out against what surrounds it.':
    'Wie sehr die Bewegung eines Pixels, oder einer Trajektorie ihr Leben lang, aus ihrer Umgebung hervorsticht.',
  'saliency {0}': 'Salienz {0}',
  'trajectory’s {0}, in context {1}': 'die der Trajektorie {0}, im Umfeld {1}',
  'Colours of saliency, dark for none to bright for most':
    'Farben der Salienz, von dunkel für keine bis hell für die höchste',
  Components: 'Komponenten',
  'Connected pieces of the foreground. Trajectories that are in two of them are not one thing.':
    'Zusammenhängende Stücke des Vordergrunds. Trajektorien in zwei verschiedenen sind nicht dasselbe Ding.',
  'a colour for each component': 'eine Farbe je Komponente',
  'foreground, too small a piece': 'Vordergrund, zu kleines Stück',
  'no component': 'keine Komponente',
  'component {0} of {1}': 'Komponente {0} von {1}',
  'The scene without the objects, as other frames show it.':
    'Die Szene ohne die Objekte, wie andere Bilder sie zeigen.',
  'never seen': 'nie zu sehen',
  'Pb and discontinuities together': 'Pb und Diskontinuitäten zusammen',
  combined: 'zusammen',
  'Discontinuities of the embedding': 'Diskontinuitäten der Einbettung',
  discontinuity: 'Diskontinuität',
  'Gradients of the eigenvectors': 'Gradienten der Eigenvektoren',
  spectral: 'spektral',
  'Pb alone': 'Nur Pb',
  'Embedding discontinuities': 'Diskontinuitäten der Einbettung',
  'Pixels that look connected lie close together in the embedding; boundaries are where its density breaks off.':
    'Pixel, die verbunden aussehen, liegen in der Einbettung nah beieinander; Grenzen sind dort, wo ihre Dichte abbricht.',
  'Known within one window only. Take at most {0} frames to see it.':
    'Nur innerhalb eines Fensters bekannt. Dazu höchstens {0} Bilder nehmen.',
  'Known when all windows are done.': 'Bekannt, wenn alle Fenster fertig sind.',
  'Needs masks, which were not asked for.': 'Braucht Masken, die nicht verlangt waren.',
  'Needs the motion of frames, which this clip came without.':
    'Braucht die Bewegung der Bilder, die diesem Clip fehlt.',
  'Nothing stands out in this clip: no trajectory is foreground.':
    'Nichts sticht in diesem Clip hervor: Keine Trajektorie ist Vordergrund.',
  'The foreground of this clip lies in pieces too small to count.':
    'Der Vordergrund dieses Clips besteht aus Stücken, die zu klein sind, um zu zählen.',
};

export const clip = {
  'Settings and results': 'Einstellungen und Ergebnisse',
  Image: 'Bild',
  'Drawn by the page itself: the camera pans over a landscape, while a balloon, a van and a walker go their own ways.':
    'Von der Seite selbst gezeichnet: Die Kamera schwenkt über eine Landschaft, während ein Ballon, ein Lieferwagen und ein Fußgänger ihre eigenen Wege gehen.',
  Start: 'Anfang',
  Frames: 'Bilder',
  Every: 'Jedes',
  '2nd': '2.',
  '3rd': '3.',
  '5th': '5.',
  'Long side': 'Lange Seite',
  'Seen at {0}': 'Gesehen mit {0}',
  '{0} of {1}, {2} to {3}': '{0} von {1}, {2} bis {3}',
  'About {0}\u00a0s on this computer': 'Etwa {0}\u00a0s auf diesem Rechner',
  'More than {0} frames are taken in windows; the first are shown while the others are computed':
    'Mehr als {0} Bilder werden in Fenstern berechnet; die ersten sind zu sehen, während die anderen entstehen',
  '{0}, {1} s at {2} fps': '{0}, {1} s mit {2} Bildern/s',
};

export const settings = {
  Settings: 'Einstellungen',
  'Reset all': 'Alle zurücksetzen',
  'All settings, stage by stage': 'Alle Einstellungen, Schritt für Schritt',
  'Changed since this run.': 'Seit dieser Berechnung geändert.',
  '{0} changed': '{0} geändert',
  'Reset {0}': '{0} zurücksetzen',
  'Back to {0}': 'Zurück auf {0}',
  'a whole number, {0} to {1}': 'eine ganze Zahl, {0} bis {1}',
  '{0} to {1}': '{0} bis {1}',
  'How large frames are when they are looked at, and whether there are masks.':
    'Wie groß Bilder sind, wenn sie betrachtet werden, und ob es Masken gibt.',
  Cuts: 'Schnitte',
  'When a frame begins a new shot of a long clip.': 'Wann ein Bild eine neue Einstellung eines langen Clips beginnt.',
  'How the motion of every pixel to the next frame is estimated.':
    'Wie die Bewegung jedes Pixels zum nächsten Bild geschätzt wird.',
  'Which points are followed through the clip, and when they are lost.':
    'Welche Punkte durch den Clip verfolgt werden, und wann sie verloren gehen.',
  'How alike two trajectories move.': 'Wie ähnlich sich zwei Trajektorien bewegen.',
  'Trajectories as points that lie close where they move alike.':
    'Trajektorien als Punkte, die nah beieinander liegen, wo sie sich gleich bewegen.',
  'Where neighbours lie far apart in the embedding.': 'Wo Nachbarn in der Einbettung weit auseinander liegen.',
  'What stands out against the motion around it.': 'Was aus der Bewegung um sich herum hervorsticht.',
  'What the pieces of the foreground keep apart and hold together.':
    'Was die Stücke des Vordergrunds trennen und zusammenhalten.',
  'From the embedding to groups of trajectories.': 'Von der Einbettung zu Gruppen von Trajektorien.',
  Contours: 'Konturen',
  'Boundaries seen in a single frame.': 'Grenzen, die in einem einzelnen Bild zu sehen sind.',
  'Pieces of a frame that lie between its contours.': 'Stücke eines Bildes, die zwischen seinen Konturen liegen.',
  'Which superpixels belong to which object.': 'Welche Superpixel zu welchem Objekt gehören.',
  'What the scene behind everything tells about the objects before it.':
    'Was die Szene hinter allem über die Objekte davor sagt.',
  'Borders of masks': 'Ränder der Masken',
  'Moving the borders of masks to the pixel.': 'Wie die Ränder der Masken aufs Pixel genau gerückt werden.',
  'Still images': 'Einzelne Bilder',
  'The embedding of the pixels of a single image.': 'Die Einbettung der Pixel eines einzelnen Bildes.',
  Joining: 'Zusammenfassen',
  'Keeping apart': 'Auseinanderhalten',
  'Higher keeps parts that move differently apart; lower makes fewer, larger objects.':
    'Höher hält Teile auseinander, die sich verschieden bewegen; niedriger gibt weniger, größere Objekte.',
  'Shaking to ignore': 'Wackeln übergehen',
  'Lower notices slower motion; higher takes more of it for shaking.':
    'Niedriger bemerkt langsamere Bewegung; höher hält mehr davon für Wackeln.',
  'px a frame': 'px je Bild',
  'Distance of points': 'Abstand der Punkte',
  'Lower finds smaller objects and takes longer.': 'Niedriger findet kleinere Objekte und dauert länger.',
  'Smoothness of masks': 'Glätte der Masken',
  'Higher gives rounder masks that lose thin parts.': 'Höher gibt rundere Masken, die dünne Teile verlieren.',
  'Higher makes fewer, larger superpixels.': 'Höher gibt weniger, größere Superpixel.',
  'Weight of the embedding': 'Gewicht der Einbettung',
  'How much its discontinuities count beside the boundaries.':
    'Wie viel ihre Diskontinuitäten neben den Grenzen zählen.',
};

export const why = {
  'Why?': 'Warum?',
  '{0} at {1}, {2} in frame {3}': '{0} bei {1}, {2} in Bild {3}',
  'The mask on screen has {0} here: it was changed by hand.': 'Die Maske zeigt hier {0}: Sie wurde von Hand geändert.',
  'A stroke over it decides.': 'Ein Strich darüber entscheidet.',
  'Its superpixel {0} is {1}; the step after the cut has moved the border over it.':
    'Sein Superpixel {0} ist {1}; der Schritt nach dem Schnitt hat die Grenze darüber geschoben.',
  'Its superpixel {0} has this label by the cut.': 'Sein Superpixel {0} ist das nach dem Schnitt.',
  'There is no other label that it could have.': 'Etwas anderes könnte es nicht sein.',
  'It would be {0} for a cost of {1} more; no number of trajectories alone would make it that.':
    'Für Kosten von {1} mehr wäre es {0}; Trajektorien allein könnten das nicht ändern.',
  'It would be {0} for a cost of {1} more: {2} more trajectories of it here would do.':
    'Für Kosten von {1} mehr wäre es {0}: {2} weitere Trajektorien davon würden hier reichen.',
  'No trajectory votes here; colours and neighbours decide.':
    'Hier stimmt keine Trajektorie ab; Farben und Nachbarn entscheiden.',
  'Trajectories that vote here: {0}, of them strangers: {1}. Their weight is {2}.':
    'Trajektorien, die hier abstimmen: {0}, davon Fremde: {1}. Ihr Gewicht ist {2}.',
  'For an object speak the background with {0} and looks with {1}; less than 0 is against.':
    'Für ein Objekt sprechen der Hintergrund mit {0} und das Aussehen mit {1}; unter 0 heißt dagegen.',
  'Links to neighbours of its own label hold it with {0}, those to others pull with {1}.':
    'Verbindungen zu Nachbarn, die dasselbe sind, halten es mit {0}, die zu anderen ziehen mit {1}.',
  'Edges between the two in this frame: {0}, of discontinuity {1} on average and {2} at most.':
    'Kanten zwischen beiden in diesem Bild: {0}, mit Diskontinuität {1} im Mittel und höchstens {2}.',
  'The nearest trajectory is {0}; it moves most like {1}.':
    'Die nächste Trajektorie ist {0}; sie bewegt sich am ehesten wie {1}.',
  'Show where labels are unsure': 'Zeigen, wo Labels unsicher sind',
  'This label is right with {0}.': 'Das Label stimmt mit {0}.',
  Reasons: 'Gründe',
  Votes: 'Stimmen',
  Colours: 'Farben',
  Evidence: 'Indizien',
  Forbidden: 'Verboten',
  Sum: 'Summe',
  'What each label would cost here; the least is taken': 'Was hier jedes Label kosten würde; das Wenigste gilt',
};
