# Compares the ports of the memory controller that Quartus generated with those that this project connects:
#     quartus_sh -t check_ddr2.tcl
# or, without Quartus, tclsh check_ddr2.tcl. Exit status 0 if they agree; else 1, and a sentence that tells what differs.

set module @MODULE@
# Port and width in bits.
set wanted {
@PORTS@
}

proc refuse {sentence} {
    puts "check_ddr2: $sentence"
    exit 1
}

set name $module.v
set again "set what README.md lists in step 2 and generate it again"
if {[catch {open [file join [file dirname [info script]] $name]} channel]} {
    refuse "there is no $name beside this script; generate the memory controller first, as in step 2 of README.md"
}
set text [read $channel]
close $channel

regsub -all {/\*.*?\*/} $text { } text
regsub -all {//[^\n]*} $text { } text
if {![regexp -indices "\\mmodule\\s+$module\\M" $text place]} {
    refuse "$name has no module $module; $again"
}
set text [string range $text [expr {[lindex $place 1] + 1}] end]
set end [string first endmodule $text]
if {$end < 0} {
    refuse "$name ends within the module $module; $again"
}

# Declarations are within the header or behind it; each ends with a semicolon, and may name several ports.
set direction {}
foreach part [regexp -all -inline {[^;,()]+|;} [string range $text 0 [expr {$end - 1}]]] {
    regsub {=.*} $part {} part
    if {$part eq ";"} {
        set direction {}
    } elseif {[regexp {^\s*(input|output|inout)\M(.*)$} $part all direction part]} {
        set width 1
        if {[regexp {\[\s*(\d+)\s*:\s*(\d+)\s*\]} $part all high low]} {
            set width [expr {abs($high - $low) + 1}]
        } elseif {[string first \[ $part] >= 0} {
            set width unknown
        }
    }
    if {$direction ne {} && [regexp {(\w+)\s*$} $part all port]} {
        set widths($port) $width
        set directions($port) $direction
    }
}

set problems {}
foreach {port width} $wanted {
    if {![info exists widths($port)]} {
        lappend problems "$port is missing"
    } elseif {$widths($port) ne $width} {
        lappend problems "$port has the width $widths($port), not $width"
    }
    set connected($port) 1
}
foreach port [lsort [array names widths]] {
    if {![info exists connected($port)] && $directions($port) ne "output"} {
        lappend problems "$port is not connected"
    }
}
if {[llength $problems]} {
    refuse "$name does not fit this project: [join $problems {, }]; $again"
}
puts "check_ddr2: the ports of $name are those that this project connects"
