//! Plots of curves as SVG.

use plotters::coord::Shift;
use plotters::prelude::*;
use std::error::Error;
use tracecut_cli::failure::{Failure, Result};

const SIZE: (u32, u32) = (720, 480);
/// Colours that remain apart for colour-blind readers (Okabe and Ito 2008); curves differ in their markers as well.
const COLOURS: [RGBColor; 6] = [
    RGBColor(0xd5, 0x5e, 0x00),
    RGBColor(0x00, 0x72, 0xb2),
    RGBColor(0x00, 0x9e, 0x73),
    RGBColor(0xcc, 0x79, 0xa7),
    RGBColor(0x56, 0xb4, 0xe9),
    RGBColor(0x00, 0x00, 0x00),
];

/// Curves over one pair of axes.
#[derive(Debug)]
pub(crate) struct Chart<'a> {
    pub(crate) title: String,
    pub(crate) x_label: &'a str,
    pub(crate) y_label: &'a str,
    /// Name and points of each curve, joined in their order. Points are not negative; others are left out.
    pub(crate) curves: Vec<(&'a str, Vec<(f64, f64)>)>,
}

impl Chart<'_> {
    /// The picture as text.
    pub(crate) fn svg(&self) -> Result<String> {
        let mut text = String::new();
        let drawn = self.draw(&SVGBackend::with_string(&mut text, SIZE).into_drawing_area());
        drawn.map_err(|e| Failure::new(format!("the plot cannot be drawn: {e}")))?;
        Ok(text)
    }

    fn draw(&self, area: &DrawingArea<SVGBackend<'_>, Shift>) -> std::result::Result<(), Box<dyn Error>> {
        area.fill(&WHITE)?;
        let mut chart = ChartBuilder::on(area)
            .caption(&self.title, ("sans-serif", 17))
            .margin(12)
            .x_label_area_size(42)
            .y_label_area_size(54)
            .build_cartesian_2d(0.0..self.end(|p| p.0), 0.0..self.end(|p| p.1))?;
        chart.configure_mesh().x_desc(self.x_label).y_desc(self.y_label).max_light_lines(0).draw()?;
        for (k, (name, points)) in self.curves.iter().enumerate() {
            let colour = COLOURS[k % COLOURS.len()];
            let points = || points.iter().copied().filter(is_drawn);
            let line = chart.draw_series(LineSeries::new(points(), colour.stroke_width(2)))?;
            let sample = move |(x, y)| PathElement::new([(x, y), (x + 26, y)], colour.stroke_width(2));
            line.label(*name).legend(sample);
            chart.draw_series(points().map(|at| match k % 3 {
                0 => Circle::new(at, 4, colour.filled()).into_dyn(),
                1 => TriangleMarker::new(at, 5, colour.filled()).into_dyn(),
                _ => Cross::new(at, 4, colour).into_dyn(),
            }))?;
        }
        let labels = &mut chart.configure_series_labels();
        labels.position(SeriesLabelPosition::UpperRight).background_style(WHITE.mix(0.9)).border_style(BLACK.mix(0.2));
        labels.draw()?;
        area.present()?;
        Ok(())
    }

    /// Where an axis ends: a little beyond the last point.
    fn end(&self, of: impl Fn(&(f64, f64)) -> f64) -> f64 {
        let points = self.curves.iter().flat_map(|curve| &curve.1).filter(|p| is_drawn(p));
        let most = points.map(of).fold(0.0, f64::max);
        if most > 0.0 { 1.04 * most } else { 1.0 }
    }
}

fn is_drawn(&(x, y): &(f64, f64)) -> bool {
    x.is_finite() && y.is_finite() && x >= 0.0 && y >= 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_have_their_names_and_what_is_no_number_is_left_out() {
        let curves = vec![("a<b", vec![(0.0, 4.0), (2.0, 0.0), (f64::NAN, 1.0)]), ("none", vec![])];
        let chart = Chart { title: "T & U".to_owned(), x_label: "missed", y_label: "y", curves };
        let svg = chart.svg().unwrap();
        for words in ["T &amp; U", "a&lt;b", "none", "missed"] {
            assert!(svg.contains(words), "{words} is not in\n{svg}");
        }
        assert_eq!(svg.matches("<circle").count(), 2, "{svg}");
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
    }

    #[test]
    fn a_chart_of_nothing_is_still_a_picture() {
        let chart = Chart { title: String::new(), x_label: "", y_label: "", curves: Vec::new() };
        assert!(chart.svg().unwrap().trim_end().ends_with("</svg>"));
    }
}
