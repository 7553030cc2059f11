//! Plots of curves as SVG: axes from 0 with round ticks, a marker for each point, a legend.

use std::fmt::Write;

/// Width and height of the picture, and how much of it lies beside the axes.
const SIZE: (f64, f64) = (720.0, 480.0);
const LEFT: f64 = 62.0;
const RIGHT: f64 = 20.0;
const TOP: f64 = 44.0;
const BOTTOM: f64 = 54.0;
/// About how many ticks an axis has.
const TICKS: f64 = 6.0;
/// Colours that remain apart for colour-blind readers (Okabe and Ito 2008); curves differ in their markers as well.
const COLOURS: [&str; 6] = ["#d55e00", "#0072b2", "#009e73", "#cc79a7", "#56b4e9", "#000000"];

/// Curves over one pair of axes.
#[derive(Debug)]
pub(crate) struct Chart<'a> {
    pub(crate) title: String,
    pub(crate) x_label: &'a str,
    pub(crate) y_label: &'a str,
    /// Name and points of each curve, joined in their order. Points are not negative; others are left out.
    pub(crate) curves: Vec<(&'a str, Vec<(f64, f64)>)>,
}

/// A linear axis from 0 to a round number.
struct Axis {
    step: f64,
    end: f64,
}

impl Axis {
    fn new(largest: f64) -> Self {
        let largest = if largest > 0.0 && largest.is_finite() { largest } else { 1.0 };
        let rough = largest / TICKS;
        let decade = 10.0_f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * decade).into_iter().find(|&s| s >= rough * (1.0 - 1e-9));
        let step = step.unwrap_or(10.0 * decade);
        Self { step, end: step * (largest / step - 1e-9).ceil().max(1.0) }
    }

    /// Values and their texts.
    fn ticks(&self) -> Vec<(f64, String)> {
        let digits = (-self.step.log10() - 1e-9).ceil().max(0.0) as usize;
        let count = (self.end / self.step).round() as usize;
        (0..=count).map(|k| k as f64 * self.step).map(|v| (v, format!("{v:.digits$}"))).collect()
    }
}

/// Both axes, and where values lie in the picture.
struct Axes {
    x: Axis,
    y: Axis,
}

impl Axes {
    fn place(&self, x: f64, y: f64) -> (f64, f64) {
        let (width, height) = (SIZE.0 - LEFT - RIGHT, SIZE.1 - TOP - BOTTOM);
        (LEFT + x / self.x.end * width, SIZE.1 - BOTTOM - y / self.y.end * height)
    }
}

impl Chart<'_> {
    /// The picture as text.
    pub(crate) fn svg(&self) -> String {
        let points = || self.curves.iter().flat_map(|c| &c.1).filter(|p| is_drawn(p));
        let axes = Axes {
            x: Axis::new(points().fold(0.0, |most, p| p.0.max(most))),
            y: Axis::new(points().fold(0.0, |most, p| p.1.max(most))),
        };
        let mut out = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {w} {h}\" width=\"{w}\" height=\"{h}\" \
             font-family=\"system-ui, sans-serif\" font-size=\"13\">\n<rect width=\"{w}\" height=\"{h}\" fill=\"#fff\"/>\n",
            w = SIZE.0,
            h = SIZE.1
        );
        self.write_axes(&mut out, &axes);
        let mut all = Vec::new();
        for (k, (_, points)) in self.curves.iter().enumerate() {
            let placed: Vec<(f64, f64)> = points.iter().filter(|p| is_drawn(p)).map(|p| axes.place(p.0, p.1)).collect();
            write_curve(&mut out, k, &placed, &placed);
            all.extend(placed);
        }
        self.write_legend(&mut out, &all);
        out + "</svg>\n"
    }

    fn write_axes(&self, out: &mut String, axes: &Axes) {
        let ((left, bottom), (right, top)) = (axes.place(0.0, 0.0), axes.place(axes.x.end, axes.y.end));
        for (value, text) in axes.x.ticks() {
            let at = axes.place(value, 0.0).0;
            line(out, (at, top), (at, bottom), "#e4e4e4");
            label(out, (at, bottom + 19.0), "middle", &text);
        }
        for (value, text) in axes.y.ticks() {
            let at = axes.place(0.0, value).1;
            line(out, (left, at), (right, at), "#e4e4e4");
            label(out, (left - 8.0, at + 4.5), "end", &text);
        }
        line(out, (left, bottom), (right, bottom), "#444");
        line(out, (left, bottom), (left, top), "#444");
        label(out, (0.5 * (left + right), SIZE.1 - 14.0), "middle", self.x_label);
        let middle = 0.5 * (top + bottom);
        let _ = writeln!(
            out,
            "<text transform=\"translate(18 {middle:.1}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
            escaped(self.y_label)
        );
        let _ = writeln!(
            out,
            "<text x=\"{left:.1}\" y=\"26\" font-size=\"15\" font-weight=\"600\">{}</text>",
            escaped(&self.title)
        );
    }

    /// In the upper corner that hides fewer of the `points`.
    fn write_legend(&self, out: &mut String, points: &[(f64, f64)]) {
        let widest = self.curves.iter().map(|c| c.0.chars().count()).max().unwrap_or(0) as f64;
        let (width, height) = (7.6 * widest + 52.0, 20.0 * self.curves.len() as f64 + 10.0);
        let top = TOP + 8.0;
        let hidden = |left: f64| {
            let inside = |p: &&(f64, f64)| p.0 > left - 12.0 && p.0 < left + width + 12.0 && p.1 < top + height + 8.0;
            points.iter().filter(inside).count()
        };
        let (near, far) = (LEFT + 8.0, SIZE.0 - RIGHT - width - 8.0);
        let left = if hidden(near) < hidden(far) { near } else { far };
        let _ = writeln!(
            out,
            "<rect x=\"{left:.1}\" y=\"{top:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" rx=\"4\" fill=\"#fff\" \
             fill-opacity=\"0.9\" stroke=\"#ccc\"/>"
        );
        for (k, (name, _)) in self.curves.iter().enumerate() {
            let y = top + 20.0 * k as f64 + 15.0;
            write_curve(out, k, &[(left + 9.0, y), (left + 35.0, y)], &[(left + 22.0, y)]);
            label(out, (left + 42.0, y + 4.5), "start", name);
        }
    }
}

fn is_drawn(&(x, y): &(f64, f64)) -> bool {
    x.is_finite() && y.is_finite() && x >= 0.0 && y >= 0.0
}

fn line(out: &mut String, from: (f64, f64), to: (f64, f64), colour: &str) {
    let _ = writeln!(
        out,
        "<path d=\"M{:.1} {:.1}L{:.1} {:.1}\" stroke=\"{colour}\" fill=\"none\"/>",
        from.0, from.1, to.0, to.1
    );
}

fn label(out: &mut String, at: (f64, f64), anchor: &str, text: &str) {
    let _ =
        writeln!(out, "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"{anchor}\">{}</text>", at.0, at.1, escaped(text));
}

/// A line along some points and a marker at others, both in the manner of curve `k`.
fn write_curve(out: &mut String, k: usize, along: &[(f64, f64)], marked: &[(f64, f64)]) {
    let colour = COLOURS[k % COLOURS.len()];
    let path: Vec<String> = along.iter().map(|(x, y)| format!("{x:.1} {y:.1}")).collect();
    if path.is_empty() {
        return;
    }
    let _ = writeln!(
        out,
        "<g stroke=\"{colour}\" stroke-width=\"1.8\" stroke-linejoin=\"round\" fill=\"#fff\"><path d=\"M{}\" \
         fill=\"none\"/>",
        path.join("L")
    );
    for &(x, y) in marked {
        let _ = match k % 5 {
            0 => writeln!(out, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3.6\" fill=\"{colour}\"/>"),
            1 => writeln!(out, "<rect x=\"{:.1}\" y=\"{:.1}\" width=\"6.4\" height=\"6.4\"/>", x - 3.2, y - 3.2),
            2 => writeln!(out, "<path d=\"M{x:.1} {:.1}l4 7h-8z\"/>", y - 4.0),
            3 => writeln!(out, "<path d=\"M{x:.1} {:.1}l4.4 4.4l-4.4 4.4l-4.4 -4.4z\"/>", y - 4.4),
            _ => writeln!(out, "<path d=\"M{:.1} {:.1}l7 7m0 -7l-7 7\"/>", x - 3.5, y - 3.5),
        };
    }
    out.push_str("</g>\n");
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(largest: f64) -> Vec<String> {
        Axis::new(largest).ticks().into_iter().map(|t| t.1).collect()
    }

    #[test]
    fn ticks_are_round_numbers_up_to_the_first_that_holds_all() {
        assert_eq!(texts(17.3), ["0", "5", "10", "15", "20"]);
        assert_eq!(texts(2.0), ["0.0", "0.5", "1.0", "1.5", "2.0"]);
        assert_eq!(texts(1.1), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0", "1.2"]);
        assert_eq!(texts(0.05), ["0.00", "0.01", "0.02", "0.03", "0.04", "0.05"]);
        assert_eq!(texts(600.0), ["0", "100", "200", "300", "400", "500", "600"]);
        for broken in [0.0, f64::INFINITY, f64::NAN] {
            assert!(Axis::new(broken).ticks().len() < 9, "{broken}");
        }
    }

    #[test]
    fn points_lie_between_the_axes_and_text_is_escaped() {
        let curves = vec![("a<b", vec![(0.0, 4.0), (2.0, 0.0), (f64::NAN, 1.0)]), ("none", vec![])];
        let chart = Chart { title: "T & U".to_owned(), x_label: "x", y_label: "y", curves };
        let svg = chart.svg();
        // Up the left axis, and at the right end of the lower one.
        assert!(svg.contains("<path d=\"M62.0 44.0L700.0 426.0\" fill=\"none\"/>"), "{svg}");
        assert!(svg.contains("T &amp; U") && svg.contains(">a&lt;b<") && svg.contains(">none<"));
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
        assert_eq!(svg.matches("<g ").count(), svg.matches("</g>").count());
    }

    #[test]
    fn the_legend_keeps_clear_of_the_points() {
        let legend_at = |points| {
            let svg = Chart { title: String::new(), x_label: "", y_label: "", curves: vec![("c", points)] }.svg();
            let at = svg.find("rx=\"4\"").unwrap();
            let from = svg[..at].rfind("x=\"").unwrap();
            svg[from + 3..].split('.').next().unwrap().parse::<u32>().unwrap()
        };
        assert!(legend_at(vec![(0.0, 2.0), (1.0, 0.0)]) > 600);
        assert_eq!(legend_at(vec![(0.0, 0.0), (1.0, 2.0)]), 70);
    }

    #[test]
    fn a_chart_of_nothing_is_still_a_picture() {
        let chart = Chart { title: String::new(), x_label: "", y_label: "", curves: Vec::new() };
        assert!(chart.svg().starts_with("<svg ") && chart.svg().ends_with("</svg>\n"));
    }
}
