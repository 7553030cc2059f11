/** The German words of the gallery. @module */

export const gallery = {
  Gallery: 'Galerie',
  'clips with their masks ready': 'Clips mit fertigen Masken',
  'On the coast': 'An der Küste',
  'The camera pans, while two boats and a balloon go their own ways.':
    'Die Kamera schwenkt, zwei Boote und ein Ballon gehen eigene Wege.',
  'In the street': 'Auf der Straße',
  'The camera stands still; a bus, a car and a walker pass.':
    'Die Kamera steht still; ein Bus, ein Auto und ein Fußgänger kommen vorbei.',
  'Two that part': 'Zwei trennen sich',
  'Two ladybirds walk alike, then each goes its own way.':
    'Zwei Marienkäfer laufen nebeneinander, dann jeder seinen eigenen Weg.',
  Forward: 'Vorwärts',
  'The camera goes forward; a car crosses ahead, a balloon drifts by.':
    'Die Kamera fährt vorwärts; ein Auto quert die Straße, ein Ballon treibt vorbei.',
  'A small ball': 'Ein kleiner Ball',
  'It bounces across a lawn, and the camera follows.': 'Er springt über eine Wiese, die Kamera folgt ihm.',
  'Behind a hedge': 'Hinter der Hecke',
  'A car passes half hidden, and a walker before it.': 'Ein Auto fährt halb verdeckt vorbei, ein Fußgänger davor.',
  'Fetching “{0}”…': '„{0}“ wird geholt …',
  '“{0}” comes by the network, which does not answer.': '„{0}“ kommt aus dem Netz, und das antwortet nicht.',
  'The gallery comes by the network, which does not answer. Everything else works without.':
    'Die Galerie kommt aus dem Netz, und das antwortet nicht. Alles andere geht ohne.',
};
