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
pre{overflow-x:auto;font-size:.85rem}summary{cursor:pointer;color:var(--link)}
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
.pair{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,29rem),1fr));gap:.6rem 2rem}
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
.tornado{width:100%;max-width:52rem}
.tornado caption{color:var(--ink)}
.tornado .bars{position:relative;width:50%;min-width:11rem;background:linear-gradient(var(--soft),var(--soft)) var(--n,-9rem) 0/1px 100% no-repeat}
.bars i{position:absolute;height:36%}
.bars .lower{top:14%;background:var(--s0)}.bars .upper{bottom:14%;background:var(--s1)}
.tornado th.n:nth-child(2){box-shadow:inset 0 3px var(--s0)}.tornado th.n:nth-child(4){box-shadow:inset 0 3px var(--s1)}
.tornado tbody th{font-weight:400;white-space:nowrap}.tornado td,.tornado tbody th{padding-block:.2rem}
svg.chart{display:block;width:100%;min-width:30rem;height:auto;font-family:inherit;font-size:12.5px;fill:var(--ink)}
svg.chart .tt{fill:var(--soft);font-size:12px}
svg.chart .at{font-size:13px}
svg.chart .ti{font-size:14.5px;font-weight:600}
svg.chart .mt,svg.chart .lt{font-size:11.8px;paint-order:stroke;stroke:var(--bg);stroke-width:3.6px;stroke-linejoin:round}
svg.chart .mt{fill:var(--soft)}svg.chart .lt{fill:var(--bad)}
.plot{overflow:visible}.plot.cut{overflow:hidden}
.axes path,.plot polyline,.key polyline,.hit{fill:none;stroke-linejoin:round}
.ax{stroke:var(--soft)}.gr{stroke:var(--grid);stroke-width:.9}.gm{stroke:var(--grid);stroke-width:.5}
.li{stroke:var(--bad);stroke-width:1.4;stroke-dasharray:9 4}
.mk{stroke:var(--soft);stroke-width:.9;stroke-dasharray:3 4}
.l0,.l1,.l2,.l3,.l4,.l5,.l6,.l7{stroke-width:1.9}
.l1{stroke-dasharray:9.5 4.5}.l2{stroke-dasharray:2.6 3;stroke-width:2.2}.l3{stroke-dasharray:13 3.8 2.6 3.8}
.l4{stroke-dasharray:6 3}.l5{stroke-dasharray:13 3.4 2.6 3 2.6 3.4}.l6{stroke-dasharray:20 5}.l7{stroke-dasharray:4.4 4.4}
.m0,.m1,.m2,.m3,.m4,.m5,.m6,.m7{fill:var(--bg);stroke-width:1.6}
.l0,.m0{stroke:var(--s0)}.l1,.m1{stroke:var(--s1)}.l2,.m2{stroke:var(--s2)}.l3,.m3{stroke:var(--s3)}
.l4,.m4{stroke:var(--s4)}.l5,.m5{stroke:var(--s5)}.l6,.m6{stroke:var(--s6)}.l7,.m7{stroke:var(--s7)}
.b0{fill:var(--s0)}
.hit{pointer-events:all}.key[role=button]{cursor:pointer}.key.off{opacity:.4}.series.off{display:none}
.axes+.plot~.hit{cursor:crosshair}
.cross{fill:none;stroke:var(--soft);stroke-width:.8;pointer-events:none}
.pick{fill:var(--link);fill-opacity:.15;stroke:var(--link);pointer-events:none}
#values{position:fixed;z-index:1;pointer-events:none;background:var(--bg);border:1px solid var(--rule);border-radius:4px;padding:.2rem .5rem;font-size:.85rem;line-height:1.35;font-variant-numeric:tabular-nums;white-space:nowrap;box-shadow:0 1px 5px #0003}
#values div{border-left:.6rem solid;padding-left:.4rem}#values span{color:var(--ink)}
.box{fill:var(--panel);stroke:var(--soft);stroke-width:1.1}
.hull{fill:none;stroke:var(--rule);stroke-width:1.4}
.fl{stroke:var(--s0);stroke-width:1.8;fill:none}.fr{stroke:var(--s1);stroke-width:1.8;fill:none}
.fla{fill:var(--s0)}.fra{fill:var(--s1)}
@media (max-width:40rem){html{font-size:15px}nav ol{columns:1}dl{grid-template-columns:1fr}dd{margin-bottom:.4rem}}
@media print{@page{margin:16mm}html{font-size:10.5pt}body{max-width:none;padding:0}a{color:inherit;text-decoration:none}nav{border:0;padding:0}
#values,.cross{display:none}.heat td,.ramp,.tornado .bars,.bars i{print-color-adjust:exact;-webkit-print-color-adjust:exact}h2,h3{break-after:avoid}.drawing,.wide{overflow:visible}svg.chart{min-width:0}.heat th:first-child{position:static}.pair{grid-template-columns:1fr 1fr}}
"#;
