//! The style sheet of every report: light, dark and paper, in one page.
//!
//! Figures carry classes only; their colours are defined here once for each surroundings.
//! The eight line colours stay apart for the common colour deficiencies and each has its
//! own dash, so that a black-and-white print tells them apart as well.

/// The style sheet's text.
pub(super) const STYLE: &str = r#"
:root{color-scheme:light dark;--bg:#fff;--ink:#1b1f24;--soft:#57606a;--rule:#d0d7de;--grid:#e3e7eb;--panel:#f6f8fa;--link:#0757ae;--good:#116329;--bad:#b3121d;--heat:#e2711d;
--s0:#0067a5;--s1:#c44601;--s2:#00785a;--s3:#a2367a;--s4:#826200;--s5:#4b3fa7;--s6:#4f565e;--s7:#0a7f8c}
@media screen and (prefers-color-scheme:dark){:root{--bg:#14181d;--ink:#e4e8ec;--soft:#9aa5b1;--rule:#3a424c;--grid:#2a313a;--panel:#1c2229;--link:#79b8ff;--good:#5bc77c;--bad:#ff8078;--heat:#d9641a;
--s0:#62b5f2;--s1:#ff9a5a;--s2:#41d0a3;--s3:#f09aca;--s4:#e3c352;--s5:#aca5ff;--s6:#b6bec7;--s7:#6cdde6}}
*{box-sizing:border-box}
html{background:var(--bg);color:var(--ink);font:16px/1.5 system-ui,-apple-system,"Segoe UI",Roboto,"Liberation Sans",Arial,sans-serif;-webkit-text-size-adjust:100%}
body{margin:0 auto;padding:1.5rem clamp(.8rem,3vw,2.5rem) 4rem;max-width:74rem}
h1{font-size:1.75rem;line-height:1.2;margin:0 0 .3rem}
h2{font-size:1.3rem;margin:2.4rem 0 .7rem;padding-bottom:.25rem;border-bottom:1px solid var(--rule)}
h3{font-size:1.05rem;margin:1.6rem 0 .5rem}
p{max-width:46rem;margin:.6rem 0}
.lead{color:var(--soft);font-size:1.05rem}
a{color:var(--link)}
code{font:.9em ui-monospace,"DejaVu Sans Mono",Consolas,monospace;overflow-wrap:anywhere}
nav{background:var(--panel);border:1px solid var(--rule);border-radius:6px;padding:.7rem 1.2rem;margin:1.4rem 0;max-width:46rem}
nav strong{display:block}
nav ol{margin:.2rem 0;padding-left:1.4rem;columns:2 17rem;column-gap:2rem}
nav a{text-decoration:none}nav a:hover{text-decoration:underline}
figure{margin:1.2rem 0;min-width:0;break-inside:avoid}
figure:target{outline:2px solid var(--link);outline-offset:6px}
figcaption{color:var(--soft);font-size:.9rem;max-width:46rem;margin:.2rem 0 .5rem}
figcaption b{color:var(--ink)}
.drawing{overflow-x:auto}
.pair{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,29rem),1fr));gap:0 2rem}
.wide{overflow-x:auto;max-width:100%}
table{border-collapse:collapse;font-size:.92rem;margin:.4rem 0;font-variant-numeric:tabular-nums}
caption{caption-side:top;text-align:left;color:var(--soft);padding-bottom:.4rem}
caption b{color:var(--ink)}
th,td{padding:.32rem .7rem;text-align:left;vertical-align:top;border-bottom:1px solid var(--rule)}
thead th{border-bottom:2px solid var(--soft);vertical-align:bottom}
thead th small{display:block;font-weight:400;color:var(--soft)}
tr{break-inside:avoid}
td.n,th.n{text-align:right;white-space:nowrap}
.claims td:first-child{white-space:nowrap;font-weight:600}
.claims .v{white-space:nowrap;font-weight:600}
.holds{color:var(--good)}.fails{color:var(--bad)}
.claims small{display:block;color:var(--soft);max-width:30rem}
blockquote{margin:0}
.heat th,.heat td{padding:.3rem .5rem;text-align:right;border:1px solid var(--bg)}
.heat thead th{text-align:right;font-weight:600;max-width:6.5rem}
.heat th:first-child{text-align:left;position:sticky;left:0;background:var(--bg)}
.heat td{background:color-mix(in srgb,var(--heat) calc(var(--v,0%)*.62),var(--panel));white-space:nowrap}
.heat td a{color:inherit;text-decoration-color:var(--soft)}
.heat td.violated{font-weight:700;outline:2px solid var(--bad);outline-offset:-2px}
.scale{font-size:.9rem;color:var(--soft)}
.nobreak{white-space:nowrap}
.ramp{display:inline-block;width:9rem;height:.8rem;vertical-align:-.08rem;background:linear-gradient(90deg,var(--panel),color-mix(in srgb,var(--heat) 62%,var(--panel)));border:1px solid var(--rule)}
dl{display:grid;grid-template-columns:max-content minmax(0,1fr);gap:.25rem 1.2rem;font-size:.92rem}
dt{color:var(--soft)}dd{margin:0;overflow-wrap:anywhere}
footer{margin-top:3rem;color:var(--soft);font-size:.85rem;border-top:1px solid var(--rule);padding-top:.6rem}
svg.chart{display:block;width:100%;min-width:30rem;height:auto;font-family:inherit}
svg.chart text{fill:var(--ink);font-size:125px}
svg.chart .tt{fill:var(--soft);font-size:120px}
svg.chart .at{font-size:130px}
svg.chart .ti{font-size:145px;font-weight:600}
svg.chart .mt,svg.chart .lt{font-size:118px;paint-order:stroke;stroke:var(--bg);stroke-width:36px;stroke-linejoin:round}
svg.chart .mt{fill:var(--soft)}svg.chart .lt{fill:var(--bad)}
svg.chart .px{font-size:12.5px}svg.chart .ti.px{font-size:14.5px;font-weight:600}svg.chart .mt.px{stroke-width:3.6px}
svg.chart .ax{stroke:var(--soft);stroke-width:10}svg.chart .gr{stroke:var(--grid);stroke-width:9}svg.chart .gm{stroke:var(--grid);stroke-width:5}
svg.chart line.px{stroke-width:1.2}svg.chart line.gr.px{stroke-width:.9}
svg.chart .li{stroke:var(--bad);stroke-width:14;stroke-dasharray:90 40}
svg.chart .mk{stroke:var(--soft);stroke-width:9;stroke-dasharray:30 40}
svg.chart [class^=l]{stroke-linejoin:round;stroke-linecap:butt}
svg.chart [class^=m]:not(text):not(.mk){fill:var(--bg)}
svg.chart .l0,svg.chart .l1,svg.chart .l2,svg.chart .l3,svg.chart .l4,svg.chart .l5,svg.chart .l6,svg.chart .l7{stroke-width:19}
svg.chart .l1{stroke-dasharray:95 45}svg.chart .l2{stroke-dasharray:26 30;stroke-width:22}svg.chart .l3{stroke-dasharray:130 38 26 38}
svg.chart .l4{stroke-dasharray:60 30}svg.chart .l5{stroke-dasharray:130 34 26 30 26 34}svg.chart .l6{stroke-dasharray:200 50}svg.chart .l7{stroke-dasharray:44 44}
svg.chart .m0,svg.chart .m1,svg.chart .m2,svg.chart .m3,svg.chart .m4,svg.chart .m5,svg.chart .m6,svg.chart .m7{stroke-width:16}
svg.chart .l0,svg.chart .m0{stroke:var(--s0)}svg.chart .l1,svg.chart .m1{stroke:var(--s1)}svg.chart .l2,svg.chart .m2{stroke:var(--s2)}svg.chart .l3,svg.chart .m3{stroke:var(--s3)}
svg.chart .l4,svg.chart .m4{stroke:var(--s4)}svg.chart .l5,svg.chart .m5{stroke:var(--s5)}svg.chart .l6,svg.chart .m6{stroke:var(--s6)}svg.chart .l7,svg.chart .m7{stroke:var(--s7)}
svg.chart .b0{fill:var(--s0)}svg.chart .b1{fill:var(--s1);fill-opacity:.75}svg.chart .b2{fill:var(--s2)}svg.chart .b3{fill:var(--s3)}
svg.chart .box{fill:var(--panel);stroke:var(--soft);stroke-width:1.1}
svg.chart .hull{fill:none;stroke:var(--rule);stroke-width:1.4}
svg.chart .fl{stroke:var(--s0);stroke-width:1.8;fill:none}svg.chart .fr{stroke:var(--s1);stroke-width:1.8;fill:none}
svg.chart .fla{fill:var(--s0)}svg.chart .fra{fill:var(--s1)}
@media (max-width:40rem){html{font-size:15px}nav ol{columns:1}dl{grid-template-columns:1fr}dd{margin-bottom:.4rem}}
@media print{@page{margin:16mm}html{font-size:10.5pt}body{max-width:none;padding:0}a{color:inherit;text-decoration:none}nav{border:0;padding:0}
.heat td,.ramp{print-color-adjust:exact;-webkit-print-color-adjust:exact}h2,h3{break-after:avoid}.drawing,.wide{overflow:visible}svg.chart{min-width:0}.heat th:first-child{position:static}.pair{grid-template-columns:1fr 1fr}}
"#;
